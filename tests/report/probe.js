// Put into a copy of the page by the tests: works its switches, and writes into the document
// what it saw.
(() => {
  const seen = { errors: [], blocked: [] };
  addEventListener("error", (event) => seen.errors.push(String(event.message)));
  addEventListener("unhandledrejection", (event) => seen.errors.push(String(event.reason)));
  addEventListener("securitypolicyviolation", (event) => seen.blocked.push(event.blockedURI));

  const all = (selector) => [...document.querySelectorAll(selector)];
  const drawn = () => all(".plot").map(
    (plot) => plot.querySelectorAll(".scatterlayer .trace:has(path.point)").length);
  const click = async (selector) => {
    document.querySelector(selector).click();
    await new Promise((resolve) => setTimeout(resolve, 300));
  };

  async function look() {
    seen.requests = performance.getEntriesByType("resource").map((entry) => entry.name);
    seen.width = innerWidth;
    seen.scroll = document.documentElement.scrollWidth;
    seen.wide = all("body *").filter((element) => !element.closest(".scroll, pre, svg")
      && element.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
      .map((element) => `${element.tagName}.${element.className}`);
    const tables = all(".scrolls > .scroll").filter((box) => box.scrollWidth > box.clientWidth + 1);
    seen.scrolling = tables.length;
    seen.said = all(".more").filter((word) => word.checkVisibility({ visibilityProperty: true })
      && word.textContent.includes("scroll")).length;
    const places = all(".plot").map((plot) => plot.getBoundingClientRect());
    seen.places = places.map((box) => [box.left, box.top, box.right, box.bottom]);
    seen.drawn = drawn();
    seen.bands = all(".plot .scatterlayer path.js-fill").length;

    const plot = document.querySelector(".plot");
    Plotly.Fx.hover(plot, [{ curveNumber: 1, pointNumber: 2 }]);
    seen.hover = plot.querySelector(".hoverlayer")?.textContent.replaceAll("\u200b", "");
    Plotly.Fx.unhover(plot);

    await click("input[name=model][value=foundation]");
    seen.withoutFoundation = drawn();
    await click("input[name=model][value=foundation]");
    await click(".switch:has([name=experiment][value='surface.qr=4.0']) [data-do=only]");
    seen.oneExperiment = drawn();
    await click("fieldset:has([name=experiment]) [data-do=all]");
    seen.again = drawn();

    const types = () => [plot._fullLayout.xaxis.type, plot._fullLayout.yaxis.type];
    seen.axes = [types()];
    await click("[data-do=xaxis]");
    seen.axes.push(types());
    await click("[data-do=yaxis]");
    seen.axes.push(types());
    seen.words = all(".tools")[0].textContent;
    document.documentElement.dataset.seen = JSON.stringify(seen);
    parent.postMessage(JSON.stringify(seen), "*");
  }

  const waiting = setInterval(() => {
    if (document.documentElement.dataset.charts !== "drawn") return;
    clearInterval(waiting);
    look().catch((error) => {
      seen.errors.push(String(error));
      document.documentElement.dataset.seen = JSON.stringify(seen);
    });
  }, 50);
})();
