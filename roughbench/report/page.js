// Glue between the page and plotly: draws the charts, and connects them with their switches.
"use strict";
(() => {
  const config = {
    displaylogo: false, responsive: true, plotlyServerURL: "", topojsonURL: "",
    showSendToCloud: false, showEditInChartStudio: false, showTips: false,
    modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d", "zoomIn2d", "zoomOut2d"],
    toImageButtonOptions: { format: "svg", filename: "roughbench" },
  };

  const all = (selector, root) => [...(root ?? document).querySelectorAll(selector)];

  // What is on in a file's switches: the values of its ticked boxes, and of its selects.
  function chosen(section) {
    const on = (name) => new Set(
      all(`input[name=${name}]`, section).filter((box) => box.checked).map((box) => box.value));
    const select = section.querySelector("select[name=pressure]");
    return { model: on("model"), experiment: on("experiment"), pressure: select?.value };
  }

  function isOn(meta, on) {
    return on.model.has(meta.model) && on.experiment.has(meta.experiment)
      && (meta.pressure === undefined || meta.pressure === on.pressure);
  }

  function setRange(axis, ranges) {
    const range = ranges?.[axis.type];
    axis.autorange = !range;
    if (range) axis.range = [...range];
    else delete axis.range;
  }

  // Chromium prints and narrow windows scale the drawing as a whole.
  function makeScalable(div) {
    for (const svg of all("svg.main-svg", div)) {
      svg.setAttribute("viewBox", `0 0 ${svg.getAttribute("width")} ${svg.getAttribute("height")}`);
      div.style.setProperty("--shape", svg.getAttribute("width") / svg.getAttribute("height"));
    }
  }

  async function draw(figure) {
    const div = figure.querySelector(".plot");
    const given = JSON.parse(figure.querySelector("script").textContent);
    const section = figure.closest(".file");
    const on = chosen(section);
    for (const trace of given.data) trace.visible = isOn(trace.meta, on);
    setRange(given.layout.yaxis, given.ranges);
    await Plotly.newPlot(div, given.data, given.layout, config);
    makeScalable(div);
    div.on("plotly_afterplot", () => makeScalable(div));
    for (const button of all("button[data-axis]", figure)) {
      const axis = button.dataset.axis;
      const show = () => {
        const isLog = div.layout[axis].type === "log";
        button.textContent = `${axis[0]}: ${isLog ? "logarithmic" : "linear"}`;
        button.setAttribute("aria-pressed", String(isLog));
      };
      button.hidden = false;
      button.addEventListener("click", async () => {
        const type = div.layout[axis].type === "log" ? "linear" : "log";
        const next = { type };
        setRange(next, axis === "yaxis" ? given.ranges : null);
        const update = { [`${axis}.type`]: type, [`${axis}.autorange`]: next.autorange };
        if (next.range) update[`${axis}.range`] = next.range;
        await Plotly.relayout(div, update);
        show();
      });
      show();
    }
  }

  function update(section) {
    const on = chosen(section);
    for (const div of all(".plot", section)) {
      if (div.data) Plotly.restyle(div, { visible: div.data.map((trace) => isOn(trace.meta, on)) });
    }
  }

  function connect(section) {
    section.querySelector(".switches").hidden = false;
    section.addEventListener("change", (event) => {
      if (event.target.closest(".switches")) update(section);
    });
    for (const button of all(".switches button", section)) {
      button.addEventListener("click", () => {
        const boxes = all("input", button.closest("fieldset"));
        const own = button.parentElement.querySelector("input");
        for (const box of boxes) box.checked = button.dataset.do === "all" || box === own;
        update(section);
      });
    }
  }

  // What is folded away on the screen is printed.
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = all("details:not([open])");
    for (const details of opened) details.open = true;
  });
  window.addEventListener("afterprint", () => {
    for (const details of opened) details.open = false;
  });

  async function start() {
    for (const section of all(".file")) connect(section);
    for (const figure of all("figure.chart")) await draw(figure);
    document.documentElement.dataset.charts = "drawn";
  }
  start();
})();
