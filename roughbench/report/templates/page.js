// Glue between the page and plotly: draws the charts, and connects them with their switches.
"use strict";
(() => {
  // No logo, no button, and no address that leads anywhere.
  const config = {
    displayModeBar: false, displaylogo: false, responsive: true, showTips: false,
    plotlyServerURL: "", topojsonURL: "",
  };
  const ink = "#222222";
  const font = "system-ui, -apple-system, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif";
  const axis = {
    showline: true, linecolor: ink, linewidth: 1, mirror: true, ticks: "inside", ticklen: 5,
    tickcolor: ink, gridcolor: "#e4e4e4", zeroline: false, exponentformat: "power",
    showexponent: "all", minor: { ticks: "inside", ticklen: 3, tickcolor: ink },
    automargin: true,
  };

  const all = (selector, root) => [...(root ?? document).querySelectorAll(selector)];

  // -- from curves to plotly's traces -----------------------------------------------------

  function layout(chart) {
    return {
      template: "none",
      font: { family: font, size: 12, color: ink },
      margin: { l: 8, r: 12, t: 10, b: 8 },
      paper_bgcolor: "white", plot_bgcolor: "white",
      showlegend: Boolean(chart.legend), hovermode: "closest", dragmode: "zoom",
      legend: {
        x: 0.03, xanchor: "left", y: chart.legend === "top" ? 0.97 : 0.03,
        yanchor: chart.legend === "top" ? "top" : "bottom", bgcolor: "rgba(255,255,255,0.8)",
      },
      hoverlabel: { bgcolor: "white", font: { color: ink, size: 12 } },
      xaxis: { ...axis, title: { text: chart.x.title }, type: chart.x.type, nticks: 6 },
      yaxis: { ...axis, title: { text: chart.y.title }, type: chart.y.type, nticks: 8 },
    };
  }

  // The outlines of a band: one polygon for every unbroken stretch.
  function band(curve) {
    const outline = { x: [], y: [] };
    for (let start = 0; start < curve.x.length; start += 1) {
      let end = start;
      while (end < curve.x.length && curve.lower[end] !== null && curve.upper[end] !== null) end += 1;
      if (end - start > 1) {
        const places = Array.from({ length: end - start }, (_, i) => start + i);
        if (outline.x.length) { outline.x.push(null); outline.y.push(null); }
        for (const i of places) { outline.x.push(curve.x[i]); outline.y.push(curve.upper[i]); }
        for (const i of places.reverse()) { outline.x.push(curve.x[i]); outline.y.push(curve.lower[i]); }
      }
      start = Math.max(start, end);
    }
    const rgb = [1, 3, 5].map((i) => Number.parseInt(curve.colour.slice(i, i + 2), 16));
    return {
      ...outline, type: "scatter", mode: "lines", fill: "toself",
      fillcolor: `rgba(${rgb},0.18)`, line: { width: 0, color: curve.colour },
      hoverinfo: "skip", showlegend: false, name: curve.name, meta: { ...curve.meta, role: "band" },
    };
  }

  function line(curve) {
    const { colour, symbol } = curve;
    const trace = {
      type: "scatter", mode: symbol ? "lines+markers" : "lines", x: curve.x, y: curve.y,
      line: { width: 1.6, color: colour, dash: curve.dash }, connectgaps: false,
      name: curve.name, meta: { ...curve.meta, role: "curve" },
      hovertemplate: curve.text ? `<b>${curve.name}</b><br>%{text}<extra></extra>`
        : `${curve.name}<br>%{x:.3g}: %{y:.3g}<extra></extra>`,
    };
    if (curve.text) trace.text = curve.text;
    if (symbol) {
      const width = symbol.endsWith("open") ? 1.2 : 0;
      trace.marker = { symbol, size: 6, color: colour, line: { width, color: colour } };
    }
    return trace;
  }

  const traces = (chart) => chart.curves.flatMap(
    (curve) => (curve.lower ? [band(curve), line(curve)] : [line(curve)]));

  // -- what is shown ----------------------------------------------------------------------

  // What is on in a file's switches: the values of its ticked boxes, and of its selects. Charts
  // outside of files have none, and show all.
  function chosen(section) {
    if (!section) return null;
    const on = (name) => new Set(
      all(`input[name=${name}]`, section).filter((box) => box.checked).map((box) => box.value));
    const select = section.querySelector("select[name=pressure]");
    return { model: on("model"), experiment: on("experiment"), pressure: select?.value };
  }

  function isOn(meta, on) {
    return on === null || on.model.has(meta.model) && on.experiment.has(meta.experiment)
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
    const on = chosen(figure.closest(".file"));
    const data = traces(given);
    for (const trace of data) trace.visible = isOn(trace.meta, on);
    const look = layout(given);
    setRange(look.yaxis, given.ranges);
    await Plotly.newPlot(div, data, look, config);
    makeScalable(div);
    div.on("plotly_afterplot", () => makeScalable(div));
    connectButtons(figure, div, given.ranges);
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
    for (const map of all("figure.map", section)) map.hidden = !isOn(map.dataset, on);
    for (const div of all(".plot", section)) {
      if (div.data) Plotly.restyle(div, { visible: div.data.map((trace) => isOn(trace.meta, on)) });
    }
  }

  function connect(section) {
    section.querySelector(".switches").hidden = false;
    for (const map of all("figure.map", section)) map.hidden = !isOn(map.dataset, chosen(section));
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

  // -- the page ---------------------------------------------------------------------------

  // A table wider than the page says so, until its end is reached.
  function watchWidths() {
    const say = (box) => {
      box.parentElement.dataset.wide = box.scrollWidth > box.clientWidth + 1
        ? (box.scrollLeft + box.clientWidth < box.scrollWidth - 2 ? "more" : "end") : "no";
    };
    const watcher = new ResizeObserver((entries) => entries.forEach((entry) => say(entry.target)));
    for (const box of all(".scrolls > .scroll")) {
      box.addEventListener("scroll", () => say(box), { passive: true });
      watcher.observe(box);
      say(box);
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

  // A link to a claim that is folded away unfolds it.
  function unfold() {
    const target = location.hash.length > 1 && document.getElementById(location.hash.slice(1));
    const details = target && target.closest("details");
    if (!details || details.open) return;
    details.open = true;
    target.scrollIntoView();
  }

  async function start() {
    watchWidths();
    addEventListener("hashchange", unfold);
    unfold();
    for (const section of all(".file")) connect(section);
    for (const figure of all("figure.chart")) await draw(figure);
    document.documentElement.dataset.charts = "drawn";
  }
  start();
})();
