"use strict";
/* The explorer of a report: data packed by fretwear.report.explorer, drawn by plotly. What it says
   of results, their labels and units, comes with the data. */
(async function () {
  const LEVELS = 10000;
  const PAUSE = 900;
  const CONFIG = { displayModeBar: false, responsive: true, doubleClick: "reset" };
  const get = (id) => document.getElementById(id);
  const [status, slider, play, compare, ownScale] = [
    "explorer-status", "cycle", "play", "compare", "own-scale",
  ].map(get);

  let study;
  status.textContent = "Unpacking the explorer …";
  try {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser cannot unpack compressed data; one of 2023 or later can");
    }
    const header = await unpacked("explorer-data").json();
    const cases = header.cases.map(unpackedCase);
    study = { ...header, points: header.points.map((point) => ({ ...point, data: cases[point.case] })) };
    const script = document.createElement("script");
    script.textContent = await unpacked("plotly-source").text();
    document.head.append(script);
    if (typeof Plotly === "undefined") throw new Error("plotly did not start");
  } catch (error) {
    status.textContent = `The explorer cannot start: ${error.message}. The figures below show the same quantities.`;
    return;
  }
  const { words } = study;

  /* ---- Data ---- */

  function unpacked(id) {
    const bytes = Uint8Array.from(atob(get(id).textContent), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
  }

  /* One case: profiles over x and histories over the cycles, in the units of the header. */
  function unpackedCase(packed) {
    const [first, spacing, count] = packed.x;
    return {
      ...packed,
      x: Array.from({ length: count }, (_, place) => first + place * spacing),
      profile(name, snapshot) {
        const { scale, steps } = packed.profiles[name][snapshot];
        let sum = 0;
        return steps.map((step) => (step === null ? null : (sum += step) * scale));
      },
      /* Stretches of x in one state: pairs of where they begin and end. */
      zones(state, snapshot) {
        const runs = packed.states[snapshot];
        const found = [];
        let edge = first - 0.5 * spacing;
        for (let place = 0; place < runs.length; place += 2) {
          const end = edge + runs[place + 1] * spacing;
          if (runs[place] === state) found.push([edge, end]);
          edge = end;
        }
        return found;
      },
    };
  }

  /* ---- Numbers, and an axis of cycles that is logarithmic and still shows 0 ---- */

  function superscript(power) {
    const digits = String(Math.abs(power)).replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit]);
    return (power < 0 ? "⁻" : "") + digits;
  }

  function number(value, digits = 4) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size < 1e-3 || size >= 1e7) {
      const [mantissa, power] = value.toExponential(digits - 1).split("e");
      return `${mantissa}·10${superscript(Number(power))}`;
    }
    const text = size >= 10 ** digits ? String(Math.round(value)) : value.toPrecision(digits);
    return text.replace("-", "−");
  }

  function cycleText(value) {
    const text = String(Math.round(value));
    return value >= 10000 ? text.replace(/\B(?=(\d{3})+$)/g, "\u2009") : text;
  }

  /* Maps cycles to positions; has the ticks, the range to show and the place of the break. */
  function cycleAxis(cycles) {
    const widthOfZero = 0.7;
    const last = Math.max(...cycles);
    const first = Math.max(1, Math.min(...cycles.filter((cycle) => cycle > 0)));
    if (!(last >= 10 * first)) {
      const margin = 0.04 * (last || 1);
      return { position: (cycle) => cycle, range: [-margin, last + margin], ticks: {} };
    }
    const zero = Math.log10(first) - widthOfZero;
    const lowest = Math.ceil(Math.log10(first));
    const powers = Array.from(
      { length: Math.floor(Math.log10(last)) - lowest + 1 }, (_, place) => lowest + place
    );
    return {
      position: (cycle) =>
        cycle >= first ? Math.log10(cycle) : zero + (widthOfZero * cycle) / first,
      range: [zero - 0.08, Math.log10(last) + 0.1],
      ticks: {
        tickvals: [zero, ...powers],
        ticktext: [0, ...powers.map((power) => (power < 4 ? 10 ** power : `10${superscript(power)}`))],
      },
      gap: zero + 0.5 * widthOfZero,
    };
  }

  /* ---- Figures: what plotly is given to draw ---- */

  const DASH = { a: "solid", b: "6px,3px" };
  const axisId = (place) => (place ? `y${place + 1}` : "y");
  const axisKey = (place) => (place ? `yaxis${place + 1}` : "yaxis");
  const largest = (values) => values.reduce((most, one) => (one > most ? one : most), 0);

  function palette() {
    const style = getComputedStyle(document.documentElement);
    const names = { a: "series-a", b: "series-b", ground: "ground", ink: "ink", muted: "muted", line: "line" };
    for (const key in names) names[key] = style.getPropertyValue(`--${names[key]}`).trim();
    return names;
  }

  function baseLayout(colors, width) {
    const family = getComputedStyle(document.body).fontFamily;
    return {
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { family, size: width < 480 ? 12 : 13, color: colors.ink },
      showlegend: false,
      separators: ".\u2009",
      hoverlabel: { bgcolor: colors.ground, bordercolor: colors.muted, font: { color: colors.ink } },
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
      margin: { l: 66, r: 12, t: 6, b: 44 },
    };
  }

  function axis(colors, text, more) {
    return {
      title: { text, standoff: 6, font: { size: 12 } },
      color: colors.ink,
      gridcolor: colors.line,
      linecolor: colors.muted,
      tickcolor: colors.muted,
      showline: true, zeroline: false, ticks: "outside", ticklen: 4, exponentformat: "none",
      ...more,
    };
  }

  /* Panels of profiles, the wear depth downwards, below a strip that shows stick and slip. */
  function profileFigure(shown, colors, width) {
    const count = study.profiles.length;
    const [strip, between] = [0.03 * shown.length, 0.03];
    const height = (1 - strip - count * between) / count;
    const right = 1.12 * largest(shown.flatMap(({ data }) => data.numbers.contact_half_width_x));
    const left = shown.some(({ data }) => data.x[0] < 0) ? -right : 0;
    const rows = shown.map((_, place) => shown.length - 1 - place);
    const data = shown.flatMap((one, place) => zoneTraces(one, rows[place], axisId(count), colors));
    const layout = {
      ...baseLayout(colors, width),
      barmode: "overlay",
      hovermode: "x",
      hoversubplots: "axis",
      height: 720 + 20 * shown.length,
      xaxis: axis(colors, words.x.label, {
        range: [left, right], anchor: axisId(count - 1), hoverformat: ".4~g",
      }),
      [axisKey(count)]: {
        domain: [1 - strip, 1],
        range: [-0.5, shown.length - 0.5],
        tickvals: rows,
        ticktext: shown.map((one) => one.key.toUpperCase()),
        ticklabelstandoff: 5, fixedrange: true, showgrid: false, zeroline: false, color: colors.ink,
      },
      shapes: shown.flatMap((one) => edges(one, 1 - strip - between, colors)),
    };
    study.profiles.forEach((name, place) => {
      const top = 1 - strip - between - place * (height + between);
      const scale = 1.06 * (highest(shown, name, right) || 1);
      layout[axisKey(place)] = axis(colors, words[name].label, {
        domain: [Math.max(0, top - height), top],
        range: name === "wear_depth" ? [scale, 0] : [0, scale],
        nticks: 5,
      });
      for (const one of shown) {
        const line = (title, values, style, more) =>
          data.push({ type: "scatter", mode: "lines", name: `${one.key} ${title}`, x: one.data.x,
            y: values, xaxis: "x", yaxis: axisId(place), line: style, ...more });
        const profile = one.data.profile(name, one.snapshot);
        if (shown.length === 1) {
          /* For one case alone: its first profile, and the limit of friction on the traction. */
          const quiet = { hoverinfo: "skip" };
          const dotted = { color: colors.muted, width: 1, dash: "1px,2.5px" };
          line(`${name} first`, one.data.profile(name, 0), dotted, quiet);
          if (name === "shear_traction" && one.data.friction !== null) {
            const limit = one.data.profile("pressure", one.snapshot).map((p) => p * one.data.friction);
            line("limit", limit, { color: colors.muted, width: 1 }, quiet);
          }
        }
        line(name, profile, { color: colors[one.key], width: 1.8, dash: DASH[one.key] }, {
          hovertemplate: `${one.key.toUpperCase()} %{y:.4~g} ${words[name].unit}<extra></extra>`,
        });
      }
    });
    return { data, layout };
  }

  /* The highest value of a profile, of all snapshots or of the one shown. The gap, which grows
     without bound outside the contact, is scaled by what is in view of the last snapshot. */
  function highest(shown, name, right) {
    return largest(shown.flatMap(({ data, snapshot }) => {
      if (name === "gap") {
        const place = ownScale.checked ? snapshot : data.cycles.length - 1;
        return data.profile(name, place).filter((_, cell) => Math.abs(data.x[cell]) <= right);
      }
      const tops = data.profiles[name].map(({ scale }) => scale * LEVELS);
      return ownScale.checked ? tops[snapshot] : tops;
    }));
  }

  function zoneTraces(one, row, yaxis, colors) {
    const color = colors[one.key];
    const hatched = { shape: "/", fgcolor: color, bgcolor: colors.ground, size: 5, solidity: 0.3 };
    const markers = {
      stick: { color, line: { width: 0 } },
      slip: { color: colors.ground, line: { color, width: 0.75 }, pattern: hatched },
    };
    return Object.entries(markers).map(([state, marker]) => {
      const zones = one.data.zones(study.states[state], one.snapshot);
      return {
        type: "bar", orientation: "h", width: 0.72, xaxis: "x", yaxis, name: `${one.key} ${state}`,
        base: zones.map(([from]) => from),
        x: zones.map(([from, to]) => to - from),
        y: zones.map(() => row),
        marker,
        hovertemplate: zones.map(
          ([from, to]) => `${state} from ${number(from)} to ${number(to)} ${words.x.unit}<extra></extra>`
        ),
      };
    });
  }

  /* Contacts that are not even from above: a map of each field, each with its colour scale on top. */
  const DEPTHS = [[0, "#ffffff"], [0.01, "#fcffa4"], [0.25, "#f98e09"], [0.5, "#bc3754"], [0.75, "#57106e"], [1, "#000004"]];

  function mapFigure(shown, colors, width) {
    const layout = baseLayout(colors, width);
    const maps = shown.flatMap((one) => study.maps.map((name) => ({ one, name })));
    const columns = width < 480 ? 1 : study.maps.length;
    const rows = maps.length / columns;
    /* Pixels: a map, what is above it, and between it and the next one to its right. */
    const [above, right] = [64, 70];
    const inner = width - layout.margin.l - layout.margin.r;
    const side = (inner - right * (columns - 1)) / columns;
    const high = rows * (side + above) + (rows - 1) * layout.margin.b;
    layout.height = high + layout.margin.t + layout.margin.b;
    const data = maps.map(({ one: { key, data: { view }, snapshot }, name }, place) => {
      const [row, column] = [Math.floor(place / columns), place % columns];
      const left = (column * (side + right)) / inner;
      const top = 1 - (row * (side + above + layout.margin.b) + above) / high;
      const across = [left, left + side / inner];
      const { scale, levels } = view.fields[name][snapshot];
      const bytes = atob(levels);
      const [x, y] = [view.x, view.y].map(([first, step, count]) =>
        Array.from({ length: count }, (_, at) => first + at * step));
      const highest = largest(shown.flatMap((one) => one.data.view.fields[name].filter(
        (_, at) => !ownScale.checked || at === one.snapshot).map((map) => 255 * map.scale)));
      const [xId, yId] = ["x", "y"].map((letter) => (place ? `${letter}${place + 1}` : letter));
      const common = { showgrid: false, nticks: 5, constrain: "domain" };
      layout[place ? `xaxis${place + 1}` : "xaxis"] = axis(colors, words.x.label, { ...common, domain: across, anchor: yId });
      layout[axisKey(place)] = axis(colors, words.y.label, {
        ...common, domain: [Math.max(0, top - side / high), top], anchor: xId, scaleanchor: xId,
      });
      return {
        type: "heatmap", xaxis: xId, yaxis: yId, x, y, name: `${key} ${name}`, zmin: 0, zmax: highest || 1,
        z: y.map((_, line) => x.map((_, cell) => scale * bytes.charCodeAt(line * x.length + cell))),
        colorscale: DEPTHS,
        colorbar: {
          orientation: "h", x: left, xanchor: "left", xpad: 0, len: side / inner, y: top, yanchor: "bottom", ypad: 8,
          thickness: 10, outlinewidth: 0, nticks: 5, ticks: "outside", ticklen: 3, tickcolor: colors.muted,
          tickfont: { color: colors.ink, size: 11 },
          title: { text: `${key.toUpperCase()}: ${words[name].label}`, side: "top", font: { color: colors.ink, size: 12 } },
        },
        hovertemplate: `%{z:.4~g} ${words[name].unit} at x = %{x:.4~g}, y = %{y:.4~g} ${words.x.unit}<extra></extra>`,
      };
    });
    return { data, layout };
  }

  /* Bearing areas of rough contacts before and after wear. */
  function heightFigure(shown, colors, width) {
    const layout = {
      ...baseLayout(colors, width), height: 320, hovermode: "x",
      xaxis: axis(colors, words.bearing_area.label, { range: [0, 100], hoverformat: ".3~g" }),
      yaxis: axis(colors, words.height.label, {}),
    };
    const data = shown.flatMap(({ key, data: { heights } }) => heights.map((values, after) => ({
      type: "scatter", mode: "lines", name: `${key} ${after ? "after" : "before"}`, y: values,
      x: values.map((_, place) => (100 * place) / (values.length - 1)),
      line: after ? { color: colors[key], width: 1.8, dash: DASH[key] } : { color: colors[key], width: 1.2, dash: "1px,2.5px" },
      hovertemplate: `${key.toUpperCase()} ${after ? "after" : "before"}: %{y:.4~g} ${words.height.unit}<extra></extra>`,
    })));
    return { data, layout };
  }

  /* The edges of stick zone and contact, through all panels. */
  function edges(one, y1, colors) {
    const color = colors[one.key];
    const at = (name) => one.data.numbers[name][one.snapshot];
    const [stick, contact] = [at("stick_half_width_x"), at("contact_half_width_x")];
    const tall = { yref: "paper", y0: 0, y1, layer: "below" };
    const sides = one.data.x[0] < 0 ? [-1, 1] : [1];
    return sides.flatMap((side) => [
      { type: "rect", x0: 0, x1: side * stick, fillcolor: color, opacity: 0.1, line: { width: 0 }, ...tall },
      { type: "line", x0: side * contact, x1: side * contact, line: { color, width: 1, dash: "dot" }, ...tall },
    ]);
  }

  /* Panels of results over the cycles: every step as a line, snapshots as dots. */
  function historyFigure(shown, cycle, colors, width) {
    const cycles = shown.flatMap(({ data }) => [...data.history.cycle, ...data.cycles]);
    const reached = cycleAxis(cycles);
    const at = reached.position(cycle);
    const last = study.histories.length - 1;
    const height = (1 - 0.08 * last) / (last + 1);
    const layout = {
      ...baseLayout(colors, width),
      hovermode: "closest",
      height: 420,
      xaxis: axis(colors, words.cycle.label, { range: reached.range, anchor: axisId(last), ...reached.ticks }),
      shapes: [{
        type: "line", x0: at, x1: at, yref: "paper", y0: 0, y1: 1, line: { color: colors.ink, width: 1.2 },
      }],
      annotations: [],
    };
    if (reached.gap !== undefined) {
      layout.annotations.push({
        x: reached.gap, xref: "x", y: 0, yref: "paper", yanchor: "middle", text: "//",
        bgcolor: colors.ground, borderpad: 0, showarrow: false, font: { color: colors.muted, size: 12 },
      });
    }
    const data = study.histories.flatMap(({ label, curves }, place) => {
      const bottom = (last - place) * (height + 0.08);
      layout[axisKey(place)] = axis(colors, label, {
        domain: [bottom, bottom + height], rangemode: "tozero", nticks: 6,
      });
      return curves.flatMap(({ name }, lower) =>
        shown.flatMap((one) => curve(one, name, axisId(place), lower ? 1.2 : 2.2, reached, colors))
      );
    });
    /* The names of curves that share a panel stand where they begin, that of the lower one below. */
    const { history } = shown[0].data;
    for (const { curves } of study.histories.filter((panel) => panel.curves.length > 1)) {
      const starts = curves.map(({ name }) => history[name][0]);
      curves.forEach(({ text }, place) => {
        const below = place && starts[place] > 0.5 * starts[0];
        layout.annotations.push({
          x: reached.position(history.cycle[0]), y: starts[place], xref: "x", yref: "y", text, showarrow: false,
          xanchor: "left", yanchor: below ? "top" : "bottom", xshift: 8, yshift: below ? -2 : 2,
          font: { color: colors.ink, size: 12 },
        });
      });
    }
    return { data, layout };
  }

  function curve(one, name, yaxis, width, reached, colors) {
    const color = colors[one.key];
    const { history, cycles, numbers } = one.data;
    const shownOr = (is, other) => cycles.map((_, place) => (place === one.snapshot ? is : other));
    const extra = `<extra>${one.key.toUpperCase()}, ${words[name].words}</extra>`;
    const text = (cycle) => `cycle ${cycleText(cycle)}: %{y:.4~g} ${words[name].unit}${extra}`;
    const common = { type: "scatter", xaxis: "x", yaxis };
    return [
      {
        ...common, mode: "lines", name: `${one.key} ${name}`,
        x: history.cycle.map(reached.position),
        y: history[name],
        line: { color, width, dash: DASH[one.key] },
        hovertemplate: history.cycle.map(text),
      },
      {
        ...common, mode: "markers", name: `${one.key} ${name} snapshots`,
        x: cycles.map(reached.position),
        y: numbers[name],
        customdata: cycles,
        marker: {
          color: shownOr(color, colors.ground), size: shownOr(11, 6), line: { color, width: 1.5 }, opacity: 1,
        },
        hovertemplate: cycles.map(text),
      },
    ];
  }

  /* ---- Selecting cases: a control for each axis ---- */

  const selected = { a: study.start, b: null };
  const selects = { a: [], b: [] };
  let cycles = [];
  let cycle = Infinity;
  let timer = null;
  let started = false;

  function makeControls(key) {
    const place = document.querySelector(`#case-${key} .choices`);
    selects[key] = study.axes.map(({ words: label, levels }) => {
      const wrapper = document.createElement("label");
      const control = document.createElement("select");
      control.append(...levels.map(([value, text]) => new Option(text, value)));
      control.addEventListener("change", () => pick(key));
      wrapper.append(label, control);
      if (levels.length > 1) place.append(wrapper);
      return control;
    });
    if (!place.childElementCount) place.append(study.points[0].title);
  }

  function pick(key) {
    const index = selects[key].map(({ value }) => value).join();
    selected[key] = study.points.findIndex((point) => point.index.join() === index);
    update();
  }

  function select(key, place) {
    selected[key] = place;
    selects[key].forEach((control, axis) => { control.value = study.points[place].index[axis]; });
  }

  /* A second case that differs from a point in as few and as late parameters as can be. */
  function neighbor(place) {
    const { index } = study.points[place];
    const distance = (other) =>
      study.points[other].index.reduce((sum, level, axis) => 2 * sum + (level !== index[axis]), 0);
    const others = [...study.points.keys()].filter((other) => other !== place && study.points[other].data);
    return others.reduce((best, other) => (distance(other) < distance(best) ? other : best), others[0] ?? place);
  }

  /* Which cases are shown, and why others cannot be. */
  function selection() {
    const shown = [];
    const problems = [];
    for (const key of compare.checked ? ["a", "b"] : ["a"]) {
      const point = study.points[selected[key]];
      const name = `Case ${key.toUpperCase()}`;
      if (!point) problems.push(`${name} is not in this page.`);
      else if (!point.data) problems.push(`${name}, point ${point.number}, is ${point.status}: ${point.reason}`);
      else shown.push({ key, point, data: point.data });
    }
    return { shown, problems };
  }

  /* ---- Drawing ---- */

  function update() {
    const { shown, problems } = selection();
    status.textContent = problems.join(" ");
    status.hidden = !problems.length;
    cycles = [...new Set(shown.flatMap(({ data }) => data.cycles))].sort((one, other) => one - other);
    slider.max = Math.max(0, cycles.length - 1);
    slider.value = Math.max(0, cycles.findLastIndex((one) => one <= cycle));
    for (const control of [slider, play]) control.disabled = cycles.length < 2;
    get("case-b").hidden = !compare.checked;
    get("extras").hidden = shown.length !== 1;
    draw();
  }

  function draw() {
    const { shown } = selection();
    for (const id of ["profile-plot", "history-plot", "maps", "heights"]) get(id).hidden = !shown.length;
    const now = cycles[Number(slider.value)] ?? 0;
    get("cycle-shown").textContent = cycleText(now);
    slider.setAttribute("aria-valuetext", `cycle ${cycleText(now)}`);
    for (const one of shown) one.snapshot = Math.max(0, one.data.cycles.findLastIndex((known) => known <= now));
    writeReadout(shown, now);
    if (!shown.length) return;
    const colors = palette();
    const titles = shown.map(({ key, point }) => `case ${key.toUpperCase()}: ${point.title}`).join("; ");
    const told = (names) => names.map((name) => words[name].words).join(", ");
    const curves = study.histories.flatMap((panel) => panel.curves.map(({ name }) => name));
    remember(now);
    get("shown-cases").textContent = `After ${cycleText(now)} cycles; ${titles}.`;
    picture("profile-plot", (width) => profileFigure(shown, colors, width),
      `Along x after ${cycleText(now)} cycles: ${told(study.profiles)}; ${titles}`);
    picture("history-plot", (width) => historyFigure(shown, now, colors, width),
      `Over the cycles: ${told(curves)}; ${titles}`);
    for (const [id, make, label, held] of [
      ["map", mapFigure, `From above: ${told(study.maps)}`, shown.filter(({ data }) => data.view)],
      ["height", heightFigure, "Bearing areas before and after wear", shown.filter(({ data }) => data.heights)],
    ]) {
      get(`${id}s`).hidden = !held.length;
      if (held.length) picture(`${id}-plot`, (width) => make(held, colors, width), `${label}; ${titles}`);
    }
  }

  function picture(id, make, label) {
    const place = get(id);
    const { data, layout } = make(place.clientWidth);
    Plotly.react(place, data, layout, CONFIG);
    place.setAttribute("aria-label", label);
  }

  function writeReadout(shown, now) {
    const [head, body] = ["thead", "tbody"].map((part) => document.querySelector(`.readout ${part}`));
    get("readout-caption").textContent = `After ${cycleText(now)} cycles`;
    const rows = study.readout.map((name) => {
      const values = shown.map((one) => one.data.numbers[name][one.snapshot]);
      const texts = values.map((value) => number(value));
      if (values.length === 2) texts.push(values[0] > 0 ? `× ${number(values[1] / values[0], 3)}` : "–");
      return [words[name].label, ...texts];
    });
    const reached = shown.map(({ data, snapshot }) => data.cycles[snapshot]);
    if (reached.some((one) => one !== now)) rows.unshift(["Last snapshot until then", ...reached.map(cycleText)]);
    const columns = shown.map((one) => one.key.toUpperCase());
    if (shown.length === 2) columns.push("B to A");
    head.replaceChildren(row(["", ...columns], () => "col"));
    body.replaceChildren(...rows.map((texts) => row(texts, (place) => place === 0 && "row")));
  }

  /* A row of a table; `scope` tells for a place whether its cell heads a row or a column. */
  function row(texts, scope) {
    const line = document.createElement("tr");
    texts.forEach((text, place) => {
      const cell = document.createElement(text && scope(place) ? "th" : "td");
      if (cell.tagName === "TH") cell.scope = scope(place);
      cell.textContent = text;
      line.append(cell);
    });
    return line;
  }

  /* ---- The address of what is shown: #case=3&with=4&cycle=1000 ---- */

  function remember(now) {
    const parts = [["case", selected.a], ["with", compare.checked ? selected.b : null]]
      .filter(([, place]) => study.points[place])
      .map(([name, place]) => `${name}=${study.points[place].number}`);
    const address = `#${[...parts, `cycle=${now}`].join("&")}`;
    if (started && location.hash !== address) window.history.replaceState(null, "", address);
  }

  /* Shows what an address asks for; returns whether it is one of the explorer. */
  function recall() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const at = (name) => study.points.findIndex(({ number: one }) => String(one) === asked.get(name));
    if (at("case") < 0) return false;
    select("a", at("case"));
    compare.checked = at("with") >= 0;
    if (compare.checked) select("b", at("with"));
    if (asked.has("cycle")) cycle = Number(asked.get("cycle"));
    update();
    return true;
  }

  addEventListener("hashchange", () => {
    if (recall()) get("explorer").scrollIntoView();
  });

  /* ---- Moving through the cycles ---- */

  function go(place) {
    slider.value = place;
    cycle = cycles[place];
    draw();
  }

  function setPlaying(yes) {
    clearInterval(timer);
    timer = yes ? setInterval(advance, PAUSE) : null;
    play.querySelector(".words").textContent = yes ? "Pause" : "Play";
    play.firstElementChild.textContent = yes ? "❚❚" : "▶";
  }

  const atEnd = () => Number(slider.value) === cycles.length - 1;

  function advance() {
    go(Math.min(Number(slider.value) + 1, cycles.length - 1));
    if (atEnd()) setPlaying(false);
  }

  slider.addEventListener("input", () => {
    if (timer) setPlaying(false);
    go(Number(slider.value));
  });
  play.addEventListener("click", () => {
    if (!timer && atEnd()) go(0);
    setPlaying(!timer);
  });
  ownScale.addEventListener("change", draw);
  compare.addEventListener("change", () => {
    if (selected.b === null) select("b", neighbor(Math.max(0, selected.a)));
    update();
  });

  /* ---- The page around it ---- */

  function linkTable() {
    const places = new Map(study.points.map((point, place) => [String(point.number), place]));
    for (const cell of document.querySelectorAll("#case-table tbody th")) {
      const place = places.get(cell.dataset.value);
      if (!study.points[place]?.data) continue;
      const link = document.createElement("a");
      link.href = `#case=${cell.dataset.value}`;
      link.textContent = cell.textContent;
      link.setAttribute("aria-label", `Show case ${cell.textContent} in the explorer`);
      cell.replaceChildren(link);
    }
  }

  for (const key of ["a", "b"]) makeControls(key);
  get("explorer-body").hidden = false;
  compare.parentElement.hidden = study.points.length < 2;
  select("a", study.start);
  update();
  linkTable();
  if (recall()) get("explorer").scrollIntoView();
  started = true;
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  for (const event of ["beforeprint", "afterprint"]) {
    addEventListener(event, () => {
      document.documentElement.classList.toggle("printing", event === "beforeprint");
      draw();
    });
  }
  get("history-plot").on("plotly_click", ({ points }) => {
    const place = cycles.indexOf(points[0].customdata);
    if (place >= 0) go(place);
  });
  document.documentElement.dataset.explorer = "ready";
})();
