"use strict";
(() => {
  const plots = JSON.parse(document.getElementById("plots").textContent);
  const hidden = new Set();
  let band = "quartiles";

  const artists = [...document.querySelectorAll(".plot svg [id*='-strategy-']")].flatMap((node) => {
    const found = /-strategy-(\d+)-([a-z]+)$/.exec(node.id);
    return found ? [{ node, place: found[1], kind: found[2] }] : [];
  });
  const keys = [...document.querySelectorAll(".key")];

  function refresh() {
    for (const { node, place, kind } of artists) {
      const otherBand = (kind === "quartiles" || kind === "confidence") && kind !== band;
      node.style.display = hidden.has(place) || otherBand ? "none" : "inline";
    }
    for (const key of keys) key.setAttribute("aria-pressed", String(!hidden.has(key.dataset.strategy)));
  }

  function toggle(place) {
    if (!hidden.delete(place)) hidden.add(place);
    refresh();
  }

  function prepareControls() {
    document.body.classList.add("live");
    for (const key of keys) {
      key.disabled = false;
      key.addEventListener("click", () => toggle(key.dataset.strategy));
      key.addEventListener("dblclick", () => only(key.dataset.strategy));
    }
    document.getElementById("all").addEventListener("click", () => { hidden.clear(); refresh(); });
    document.getElementById("none").addEventListener("click", () => {
      for (const key of keys) hidden.add(key.dataset.strategy);
      refresh();
    });
    document.getElementById("band").addEventListener("change", (event) => { band = event.target.value; refresh(); });
    refresh();
  }

  function only(place) {
    for (const key of keys) hidden.add(key.dataset.strategy);
    hidden.delete(place);
    refresh();
  }

  function fraction(axis, value) {
    const [low, high, logarithmic] = axis;
    return logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  }

  function inverse(axis, share) {
    const [low, high, logarithmic] = axis;
    return logarithmic ? low * Math.pow(high / low, share) : low + share * (high - low);
  }

  function words(value) {
    return value === null ? "–" : String(Number(value.toPrecision(4)));
  }

  function element(tag, parent, attributes = {}, text = "") {
    const drawing = parent instanceof SVGElement;
    const made = drawing ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  }

  function prepareCrosshair(name, plot) {
    const figure = document.getElementById(name);
    const svg = figure.querySelector("svg");
    const box = svg.viewBox.baseVal;
    const [left, top, right, bottom] = plot.frame;
    const readout = element("div", figure, { class: "readout", role: "status" });
    readout.hidden = true;
    svg.parentElement.after(readout);
    const marks = element("g", svg, { class: "crosshair", "pointer-events": "none" });
    let current = plot.numbers.length - 1;

    function show(index) {
      current = Math.min(Math.max(index, 0), plot.numbers.length - 1);
      const number = plot.numbers[current];
      const x = box.width * (left + (right - left) * fraction(plot.x, number));
      marks.replaceChildren();
      element("line", marks, { x1: x, x2: x, y1: top * box.height, y2: bottom * box.height, stroke: "#444", "stroke-width": 0.8 });
      const seen = plot.series.filter((series) => !hidden.has(String(series.place)) && series.values[current] !== null);
      seen.sort((a, b) => (plot.maximised ? -1 : 1) * (a.values[current] - b.values[current]));
      for (const series of seen) {
        const height = fraction(plot.y, series.values[current]);
        if (height < 0 || height > 1) continue;
        const y = box.height * (bottom - (bottom - top) * height);
        element("circle", marks, { cx: x, cy: y, r: 3.5, fill: series.colour, stroke: "#fff", "stroke-width": 0.8 });
      }
      tell(number, seen);
      readout.style.left = x < box.width / 2 ? "auto" : "3.5rem";
      readout.style.right = x < box.width / 2 ? "1rem" : "auto";
    }

    function tell(number, seen) {
      readout.replaceChildren();
      element("b", readout, {}, `evaluation ${number}${plot.unit ? ` [${plot.unit}]` : ""}`);
      const table = element("table", readout);
      for (const series of seen) {
        const row = element("tr", table);
        element("i", element("td", row), { style: `background:${series.colour}` });
        element("td", row, {}, series.label);
        element("td", row, { class: "number" }, words(series.values[current]));
        const spread = series.lower ? `${words(series.lower[current])} … ${words(series.upper[current])}` : "";
        element("td", row, { class: "number" }, spread);
      }
      readout.hidden = false;
    }

    function hide() {
      readout.hidden = true;
      marks.replaceChildren();
    }

    function follow(event) {
      const place = svg.getBoundingClientRect();
      const share = ((event.clientX - place.left) / place.width - left) / (right - left);
      if (share < -0.03 || share > 1.03) return hide();
      const value = inverse(plot.x, Math.min(Math.max(share, 0), 1)) + 0.5;
      const after = plot.numbers.findIndex((number) => number > value);
      show(after < 0 ? plot.numbers.length - 1 : after - 1);
    }

    figure.tabIndex = 0;
    svg.addEventListener("pointermove", follow);
    svg.addEventListener("pointerdown", follow);
    svg.addEventListener("pointerleave", (event) => { if (event.pointerType === "mouse") hide(); });
    figure.addEventListener("blur", hide);
    figure.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      show(readout.hidden ? current : current + step);
    });
  }

  function prepareTable(table) {
    const body = table.tBodies[0];
    [...table.tHead.rows[0].cells].forEach((head, column) => {
      const link = head.querySelector("a");
      const button = document.createElement("button");
      button.type = "button";
      button.title = "sort";
      if (link) link.after(button);
      else {
        button.append(...head.childNodes);
        head.append(button);
      }
      button.addEventListener("click", () => sort(table, body, head, column));
    });
  }

  function sort(table, body, head, column) {
    const descending = head.getAttribute("aria-sort") === "ascending";
    for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", descending ? "descending" : "ascending");
    const text = (row) => row.cells[column].textContent.trim();
    const rows = [...body.rows];
    const numbers = rows.map((row) => parseFloat(text(row)));
    const numeric = numbers.some((number) => !Number.isNaN(number)) && head.classList.contains("number");
    const order = rows.map((row, place) => ({ row, number: numbers[place], text: text(row) }));
    order.sort((a, b) => {
      const missing = Number.isNaN(a.number) - Number.isNaN(b.number);
      if (numeric && missing) return missing;
      const difference = numeric ? a.number - b.number || 0 : a.text.localeCompare(b.text, "en", { numeric: true });
      return descending ? -difference : difference;
    });
    body.append(...order.map((item) => item.row));
  }

  function prepareDetails() {
    const folded = [...document.querySelectorAll("details")];
    let closed = [];
    addEventListener("beforeprint", () => {
      closed = folded.filter((item) => !item.open);
      for (const item of closed) item.open = true;
    });
    addEventListener("afterprint", () => { for (const item of closed) item.open = false; });
  }

  prepareControls();
  for (const [name, plot] of Object.entries(plots)) prepareCrosshair(name, plot);
  document.querySelectorAll("table.sortable").forEach(prepareTable);
  prepareDetails();
})();
