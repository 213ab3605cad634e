"""Settings of Sphinx for the site; ``make site`` runs it by website/build.py."""

from __future__ import annotations

import importlib
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.addnodes import desc_signature, pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.writers.html5 import HTML5Translator

import roughbench

project = "roughbench"
author = "the roughbench developers"
copyright = author  # noqa: A001  (Sphinx wants this name)
version = release = roughbench.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]

# Pages are what a forge shows: plain Markdown, with the anchors that it makes of headings.
myst_enable_extensions = ["html_image"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
nb_execution_mode = "off"  # they come as scripts/run_notebooks.py has run them
nb_merge_streams = True
suppress_warnings = ["ref.python"]  # attributes of two classes may have one name

napoleon_numpy_docstring = True
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = False
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "exclude-members": "model_config, model_post_init"}
python_maximum_signature_line_length = 80

# Types in docstrings are words, such as "path" or "array_like", and may name what is internal;
# what is named as public has to be there.
nitpick_ignore_regex = [(r"py:.*", r"(?!roughbench\.\w+$).*"), (r"py:mod", r".*")]

html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"roughbench {release}"
html_static_path = ["static"]
html_css_files = ["style.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}

linkcheck_timeout = 20
linkcheck_workers = 4


def escape_bars(
    _app: Sphinx, _what: str, _name: str, _thing: object, _options: Any, lines: list[str]
) -> None:
    """Keep |q| of a formula from being taken for a substitution."""
    lines[:] = [line if "`" in line else line.replace("|", r"\|") for line in lines]


def find_public_name(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement
) -> nodes.Node | None:
    """Lead what names a public object by its module, `roughbench.spec.load_spec`, to it."""
    target = str(node.get("reftarget", ""))
    name = target.rpartition(".")[2]
    if not target.startswith("roughbench.") or name not in roughbench.__all__:
        return None
    domain = env.domains.python_domain
    found = domain.objects.get(f"roughbench.{name}")
    if found is None:
        return None
    node = node.copy()
    node["reftarget"] = f"roughbench.{name}"
    return domain.resolve_xref(
        env, node["refdoc"], app.builder, node["reftype"], node["reftarget"], node, content
    )


def inline_formula(self: HTML5Translator, node: nodes.math) -> None:
    """Write a formula in a line as MathML, which browsers know without a script."""
    self.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def block_formula(self: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula that stands alone."""
    formula = tex2mathml(node.astext()).replace("<math ", '<math display="block" ', 1)
    self.body.append(f'<div class="formula">{formula}</div>')
    raise nodes.SkipNode


def add_anchors(_app: Sphinx, doctree: nodes.document) -> None:
    """Give what is described an anchor for each name that viewcode may lead back to.

    It takes all that a file defines for described under one module, and here some is described
    as ``roughbench.plot`` and some as ``roughbench.figures.available``.
    """
    for signature in doctree.findall(desc_signature):
        module, name = str(signature.get("module", "")), str(signature.get("fullname", ""))
        if module.partition(".")[0] != "roughbench":
            continue
        thing = getattr(importlib.import_module(module), name.partition(".")[0], None)
        for one in dict.fromkeys(("roughbench", module, getattr(thing, "__module__", module))):
            if f"{one}.{name}" not in signature["ids"]:
                signature["ids"].append(f"{one}.{name}")


def setup(app: Sphinx) -> None:
    """Connect them."""
    app.add_html_math_renderer("mathml", (inline_formula, None), (block_formula, None))
    app.connect("autodoc-process-docstring", escape_bars)
    app.connect("missing-reference", find_public_name)
    app.connect("doctree-read", add_anchors)
