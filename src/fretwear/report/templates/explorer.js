"use strict";
/* The explorer: what is chosen, which cycle, and the pictures and numbers that follow. */
(async function () {
  const status = document.getElementById("explorer-status");
  if (!status) return;
  const { number, cycleNumber, profiles, histories } = window.fretwear;
  const get = (id) => document.getElementById(id);
  const [slider, play, compare, ownScale] = ["cycle", "play", "compare", "own-scale"].map(get);
  const CONFIG = { displayModeBar: false, responsive: true, doubleClick: "reset" };
  const PAUSE = 900;
  const READOUT = [
    ["contact", "Contact half-width"],
    ["stick", "Stick half-width"],
    ["peak", "Highest pressure"],
    ["central", "Central pressure"],
    ["deepest", "Deepest wear"],
    ["volume", "Wear volume"],
    ["energy", "Energy per cycle"],
  ];

  let study;
  status.textContent = "Unpacking the explorer …";
  try {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser cannot unpack compressed data; one of 2023 or later can");
    }
    study = await window.fretwear.study();
    await window.fretwear.plotly();
  } catch (error) {
    status.textContent = `The explorer cannot start: ${error.message}. The figures below show the same quantities.`;
    return;
  }
  const byIndex = new Map(study.points.map((point, place) => [point.index.join(), place]));
  const chosen = { a: study.start, b: null };
  const selects = { a: [], b: [] };
  let cycles = [];
  let cycle = Infinity;
  let timer = null;

  /* Choosing cases: one control for each varied parameter of a grid, one for all points else. */

  function select(label, options, place, change) {
    const wrapper = document.createElement("label");
    const control = document.createElement("select");
    for (const [value, text] of options) control.append(new Option(text, value));
    control.addEventListener("change", change);
    wrapper.append(label, control);
    place.append(wrapper);
    return control;
  }

  function makeControls(key) {
    const place = document.querySelector(`#case-${key} .choices`);
    const varied = study.axes.filter((axis) => axis.levels.length > 1);
    if (study.axes.length) {
      selects[key] = study.axes.map((axis) =>
        varied.includes(axis) ? select(axis.words, axis.levels, place, () => pick(key)) : null
      );
      if (!varied.length) place.append(study.points[0].title);
    } else if (study.points.length > 1) {
      const options = study.points.map((point, at) => [at, `${point.number}: ${point.title}`]);
      selects[key] = [select("point", options, place, () => pick(key))];
    } else {
      place.append(study.points[0].title);
    }
  }

  function pick(key) {
    if (!study.axes.length) {
      chosen[key] = Number(selects[key][0].value);
    } else {
      const index = selects[key].map((control, axis) =>
        control ? control.value : study.axes[axis].levels[0][0]
      );
      chosen[key] = byIndex.get(index.join()) ?? -1;
    }
    update();
  }

  function show(key, place) {
    chosen[key] = place;
    const { index } = study.points[place];
    if (study.axes.length) {
      selects[key].forEach((control, axis) => {
        if (control) control.value = index[axis];
      });
    } else if (selects[key].length) {
      selects[key][0].value = place;
    }
  }

  /* A second case that differs from a point in one parameter, the last that can be changed. */
  function neighbor(place) {
    const { index } = study.points[place];
    const isDone = (other) => other !== undefined && other !== place && study.points[other].data;
    for (let axis = study.axes.length - 1; axis >= 0; axis -= 1) {
      for (const [level] of study.axes[axis].levels) {
        const other = byIndex.get(index.with(axis, level).join());
        if (isDone(other)) return other;
      }
    }
    const others = study.points.map((_, other) => other);
    return others.find((other) => other > place && isDone(other)) ?? others.find(isDone) ?? place;
  }

  /* Which cases are shown, and what is to be said of those that cannot be. */
  function selection() {
    const shown = [];
    const problems = [];
    for (const key of compare.checked ? ["a", "b"] : ["a"]) {
      const point = study.points[chosen[key]];
      const name = key.toUpperCase();
      if (!point) problems.push(`Case ${name} is not held by this page.`);
      else if (!point.data) {
        problems.push(`Case ${name}, point ${point.number}, is ${point.status}: ${point.reason}`);
      } else shown.push({ key, point, data: point.data });
    }
    return { shown, problems };
  }

  /* Drawing. */

  function update() {
    const { shown, problems } = selection();
    status.textContent = problems.join(" ");
    status.hidden = !problems.length;
    const known = shown.flatMap((one) => one.data.cycles);
    cycles = [...new Set(known)].sort((one, other) => one - other);
    slider.max = Math.max(0, cycles.length - 1);
    const near = cycles.findLastIndex((one) => one <= cycle);
    slider.value = Math.max(0, near);
    for (const control of [slider, play]) control.disabled = cycles.length < 2;
    get("case-b").hidden = !compare.checked;
    get("extras").hidden = shown.length !== 1;
    draw();
  }

  function draw() {
    const { shown } = selection();
    for (const id of ["profile-plot", "history-plot"]) get(id).hidden = !shown.length;
    const now = cycles[Number(slider.value)] ?? 0;
    get("cycle-shown").textContent = cycleNumber(now);
    slider.setAttribute("aria-valuetext", `cycle ${cycleNumber(now)}`);
    for (const one of shown) one.snapshot = one.data.snapshot(now);
    write(shown, now);
    if (!shown.length) return;
    const titles = shown.map((one) => `case ${one.key.toUpperCase()}: ${one.point.title}`).join("; ");
    get("shown-cases").textContent = `After ${cycleNumber(now)} cycles; ${titles}.`;
    picture("profile-plot", (width) => profiles(shown, study.units, ownScale.checked, width),
      `Pressure, shear traction, gap and wear depth along x after ${cycleNumber(now)} cycles; ${titles}`);
    picture("history-plot", (width) => histories(shown, study.units, now, width),
      `Half-widths of contact and stick zone, and wear volume, over the cycles; ${titles}`);
  }

  function picture(id, make, words) {
    const place = get(id);
    const { data, layout } = make(place.clientWidth);
    Plotly.react(place, data, layout, CONFIG);
    place.setAttribute("aria-label", words);
  }

  function row(parent, header, texts) {
    const line = parent.insertRow();
    const first = document.createElement("th");
    first.scope = "row";
    first.textContent = header;
    line.append(first);
    for (const text of texts) line.insertCell().textContent = text;
    return line;
  }

  function write(shown, now) {
    const table = document.querySelector(".readout");
    get("readout-caption").textContent = `After ${cycleNumber(now)} cycles`;
    const [head] = [table.tHead];
    head.replaceChildren();
    table.tBodies[0].replaceChildren();
    const columns = shown.map((one) => one.key.toUpperCase());
    if (shown.length === 2) columns.push("B to A");
    const heading = head.insertRow();
    for (const text of ["", ...columns]) {
      const cell = document.createElement(text ? "th" : "td");
      if (text) cell.scope = "col";
      cell.textContent = text;
      heading.append(cell);
    }
    if (shown.some((one) => one.data.cycles[one.snapshot] !== now)) {
      const reached = shown.map((one) => cycleNumber(one.data.cycles[one.snapshot]));
      row(table.tBodies[0], "Last snapshot until then", reached);
    }
    for (const [name, words] of READOUT) {
      const values = shown.map((one) => one.data.scalars[name][one.snapshot]);
      const texts = values.map((value) => number(value));
      if (values.length === 2) texts.push(values[0] > 0 ? "× " + number(values[1] / values[0], 3) : "–");
      row(table.tBodies[0], `${words} (${study.units[name]})`, texts);
    }
  }

  /* Moving through the cycles. */

  function go(place) {
    slider.value = place;
    cycle = cycles[place];
    draw();
  }

  function stop() {
    clearInterval(timer);
    timer = null;
    playing(false);
  }

  function playing(yes) {
    play.querySelector(".words").textContent = yes ? "Pause" : "Play";
    play.firstElementChild.textContent = yes ? "❚❚" : "▶";
  }

  function start() {
    if (Number(slider.value) === Number(slider.max)) go(0);
    playing(true);
    timer = setInterval(() => {
      go(Math.min(Number(slider.value) + 1, Number(slider.max)));
      if (Number(slider.value) === Number(slider.max)) stop();
    }, PAUSE);
  }

  slider.addEventListener("input", () => {
    if (timer) stop();
    go(Number(slider.value));
  });
  play.addEventListener("click", () => (timer ? stop() : start()));
  ownScale.addEventListener("change", draw);
  compare.addEventListener("change", () => {
    if (chosen.b === null) show("b", neighbor(Math.max(0, chosen.a)));
    update();
  });

  /* Rows of the table of cases lead here. */
  function linkTable() {
    const places = new Map(study.points.map((point, place) => [String(point.number), place]));
    for (const cell of document.querySelectorAll("#case-table tbody th")) {
      const place = places.get(cell.dataset.value);
      if (place === undefined || !study.points[place].data) continue;
      const link = document.createElement("a");
      link.href = "#explorer";
      link.textContent = cell.textContent;
      link.setAttribute("aria-label", `Show case ${cell.textContent} in the explorer`);
      link.addEventListener("click", () => {
        show("a", place);
        update();
      });
      cell.replaceChildren(link);
    }
  }

  function follow() {
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
    const printing = (yes) => () => {
      document.documentElement.classList.toggle("printing", yes);
      draw();
    };
    addEventListener("beforeprint", printing(true));
    addEventListener("afterprint", printing(false));
    get("history-plot").on("plotly_click", ({ points }) => {
      const place = cycles.indexOf(points[0].customdata);
      if (place >= 0) go(place);
    });
  }

  for (const key of ["a", "b"]) makeControls(key);
  get("explorer-body").hidden = false;
  get("compare").parentElement.hidden = study.points.length < 2;
  show("a", study.start);
  update();
  follow();
  linkTable();
  document.documentElement.dataset.explorer = "ready";
})();
