// Glue between the page and plotly: draws the charts, and connects them with their switches.
"use strict";
(() => {
  // No logo, no button, and no address that leads anywhere.
  const config = {
    displayModeBar: false, displaylogo: false, responsive: true, showTips: false,
    plotlyServerURL: "", topojsonURL: "",
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

  // A map shows one state; without it, nothing is left to show.
  const isMap = (div) => div.data[0].meta.role === "map";

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
    connectButtons(figure, div, given.ranges);
    figure.hidden = isMap(div) && !given.data[0].visible;
  }

  // Below a chart: the kind of each axis, the whole range, a file of the picture.
  function connectButtons(figure, div, ranges) {
    const isLog = (axis) => div.layout[axis].type === "log";
    const goTo = (types) => {
      const update = {};
      for (const [axis, type] of Object.entries(types)) {
        const next = { type };
        setRange(next, axis === "yaxis" ? ranges : null);
        for (const [key, value] of Object.entries(next)) update[`${axis}.${key}`] = value;
      }
      return Plotly.relayout(div, update);
    };
    const actions = {
      xaxis: () => goTo({ xaxis: isLog("xaxis") ? "linear" : "log" }),
      yaxis: () => goTo({ yaxis: isLog("yaxis") ? "linear" : "log" }),
      reset: () => goTo({ xaxis: div.layout.xaxis.type, yaxis: div.layout.yaxis.type }),
      save: () => Plotly.downloadImage(div, {
        format: "svg", filename: figure.dataset.name, width: div.clientWidth, height: div.clientHeight,
      }),
    };
    const show = () => {
      for (const button of all("button[data-do$=axis]", figure)) {
        const axis = button.dataset.do;
        button.textContent = `${axis[0]}: ${isLog(axis) ? "logarithmic" : "linear"}`;
      }
    };
    for (const button of all(".tools button", figure)) {
      button.addEventListener("click", async () => {
        await actions[button.dataset.do]();
        show();
      });
    }
    figure.querySelector(".tools").hidden = false;
    show();
  }

  function update(section) {
    const on = chosen(section);
    for (const div of all(".plot", section)) {
      if (!div.data) continue;
      const visible = div.data.map((trace) => isOn(trace.meta, on));
      const figure = div.closest("figure");
      const wasHidden = figure.hidden;
      figure.hidden = isMap(div) && !visible[0];
      Plotly.restyle(div, { visible });
      if (wasHidden && !figure.hidden) Plotly.Plots.resize(div);
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
