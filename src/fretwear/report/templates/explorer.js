"use strict";
/* The explorer of a report: data of fretwear.report.explorer, drawn by plotly. What it says of
   results, their labels and units, comes with the data. */
(async function () {
  const PAUSE = 900;
  const CONFIG = { displayModeBar: false, responsive: true, doubleClick: "reset" };
  const get = (id) => document.getElementById(id);
  const [status, slider, play, compare, ownScale, along] = [
    "explorer-status", "cycle", "play", "compare", "own-scale", "along",
  ].map(get);

  const unpacked = (id) => {
    const bytes = Uint8Array.from(atob(get(id).textContent), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
  };

  let study;
  status.textContent = "Unpacking the explorer …";
  try {
    if (typeof DecompressionStream === "undefined") {
      throw new Error("this browser cannot unpack compressed data; one of 2023 or later can");
    }
    study = await unpacked("explorer-data").json();
    const script = document.createElement("script");
    script.textContent = await unpacked("plotly-source").text();
    document.head.append(script);
    if (typeof Plotly === "undefined") throw new Error("plotly did not start");
  } catch (error) {
    status.textContent = `The explorer cannot start: ${error.message}. `
      + "The figures below show the same quantities.";
    return;
  }
  const { words, points } = study;
  const places = ([first, step, count]) =>
    Array.from({ length: count }, (_, at) => first + at * step);
  /* A row of values, of which the page has the differences. */
  const summed = ({ scale, steps }) => {
    let sum = 0;
    return steps.map((step) => (step === null ? null : (sum += step) * scale));
  };
  for (const one of study.cases) {
    for (const line of [one, one.across ?? []]) {
      if (line.x) line.x = places(line.x);
      for (const name in line.profiles) line.profiles[name] = line.profiles[name].map(summed);
    }
    for (const name of one.view ? study.maps : []) {
      one.view.fields[name] = one.view.fields[name].map((rows) => rows.map(summed));
    }
  }
  for (const point of points) point.data = study.cases[point.case];

  /* ---- Numbers, and an axis of cycles that is logarithmic and still shows 0 ---- */

  const formatted = (value, options) =>
    new Intl.NumberFormat("en", { useGrouping: "min2", maximumFractionDigits: 0, ...options })
      .format(value).replaceAll(",", "\u2009").replace("-", "−");
  const superscript = (power) =>
    String(power).replace(/[-\d]/g, (sign) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign] ?? "⁻");

  function number(value, digits = 4) {
    if (value === null) return "–";
    const size = Math.abs(value);
    if (size && (size < 1e-3 || size >= 1e7)) {
      const [mantissa, power] = value.toExponential(digits - 1).split("e");
      return `${mantissa}·10${superscript(Number(power))}`;
    }
    const significant = { minimumSignificantDigits: digits, maximumSignificantDigits: digits };
    return formatted(value, size && { ...significant, roundingPriority: "morePrecision" });
  }

  /* Maps cycles to positions; has the ticks, the range to show and the place of the break. */
  function cycleAxis(cycles) {
    const widthOfZero = 0.7;
    const last = Math.max(...cycles);
    const first = Math.max(1, Math.min(...cycles.filter((cycle) => cycle > 0)));
    if (!(last >= 10 * first)) {
      const margin = 0.04 * (last || 1);
      return { position: (cycle) => cycle, range: [-margin, last + margin] };
    }
    const [start, end] = [first, last].map(Math.log10);
    const zero = start - widthOfZero;
    const powers = [];
    for (let power = Math.ceil(start); power <= end; power++) powers.push(power);
    return {
      position: (one) => (one >= first ? Math.log10(one) : zero + (widthOfZero * one) / first),
      range: [zero - 0.08, end + 0.1],
      tickvals: [zero, ...powers],
      ticktext: [0, ...powers.map((one) => (one < 4 ? 10 ** one : `10${superscript(one)}`))],
      gap: zero + 0.5 * widthOfZero,
    };
  }

  /* ---- Figures: what plotly is given to draw ---- */

  const DASH = { a: "solid", b: "6px,3px" };
  const DEPTHS = [
    [0, "#ffffff"], [0.01, "#fcffa4"], [0.25, "#f98e09"], [0.5, "#bc3754"],
    [0.75, "#57106e"], [1, "#000004"],
  ];
  /* What a case has along the axis chosen: places x there, zones, profiles and half-widths. */
  const lineOf = (data) => (along.value === "y" && data.across) || data;
  const largest = (values) => values.reduce((most, one) => (one > most ? one : most), 0);
  let colors;

  const axis = (text, more) => ({
    title: { text, standoff: 6, font: { size: 12 } },
    color: colors.ink,
    gridcolor: colors.line,
    linecolor: colors.muted,
    tickcolor: colors.muted,
    showline: true, zeroline: false, ticks: "outside", ticklen: 4, exponentformat: "none",
    ...more,
  });

  /* A layout of panels below each other, which share the first axis. */
  function panels(height, x, ys, more = {}) {
    const ids = ys.map((_, place) => (place ? `y${place + 1}` : "y"));
    return {
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: colors.font, size: innerWidth < 480 ? 12 : 13, color: colors.ink },
      showlegend: false,
      separators: ".\u2009",
      hoverlabel: {
        bgcolor: colors.ground, bordercolor: colors.muted, font: { color: colors.ink },
      },
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
      margin: { l: 66, r: 12, t: 6, b: 44 },
      height,
      xaxis: { ...x, anchor: ids.at(-1) },
      ...Object.fromEntries(ys.map((y, place) => [ids[place].replace("y", "yaxis"), y])),
      ...more,
      grid: { rows: ys.length, columns: 1, xaxes: ["x"], yaxes: ids, ygap: 0.13, ...more.grid },
    };
  }

  const curve = (name, place, x, y, line, hover) => ({
    type: "scatter", mode: "lines", xaxis: "x", yaxis: `y${place + 1}`, name, x, y, line,
    ...(hover ? { hovertemplate: hover } : { hoverinfo: "skip" }),
  });

  /* Panels of profiles, the wear depth downwards, below a strip that shows stick and slip. */
  function profileFigure(shown) {
    const strip = study.profiles.length;
    const top = 1 - 0.03 * shown.length;
    /* The scar of a stroke extends beyond the contact. */
    const right = 1.12 * largest(shown.flatMap(({ data }) => {
      const { x, profiles, numbers } = lineOf(data);
      const worn = profiles.wear_depth?.at(-1) ?? [];
      const scar = x.filter((_, at) => worn[at] > 0.01 * largest(worn)).map(Math.abs);
      return [...numbers[`contact_half_width_${along.value}`], ...scar];
    }));
    const left = shown.some(({ data }) => lineOf(data).x[0] < 0) ? -right : 0;
    const ys = study.profiles.map((name) => {
      const scale = 1.06 * (highest(shown, name, right) || 1);
      const range = name === "wear_depth" ? [scale, 0] : [0, scale];
      return axis(words[name].label, { range, nticks: 5 });
    });
    const x = axis(words[along.value].label, { range: [left, right], hoverformat: ".4~g" });
    const layout = panels(720 + 20 * shown.length, x, ys, {
      barmode: "overlay",
      hovermode: "x",
      hoversubplots: "axis",
      grid: { domain: { y: [0, top - 0.03] } },
      shapes: shown.flatMap((one) => edges(one, top - 0.03)),
      [`yaxis${strip + 1}`]: {
        domain: [top, 1],
        range: [shown.length - 0.5, -0.5],
        tickvals: shown.map((_, row) => row),
        ticktext: shown.map((one) => one.key.toUpperCase()),
        ticklabelstandoff: 5, fixedrange: true, showgrid: false, zeroline: false, color: colors.ink,
      },
    });
    const drawn = shown.flatMap((one, row) => zones(one, row, `y${strip + 1}`));
    study.profiles.forEach((name, place) => {
      for (const { key, snapshot, data } of shown) {
        const [{ x, profiles }, { friction }] = [lineOf(data), data];
        const add = (title, values, line, hover) =>
          drawn.push(curve(`${key} ${title}`, place, x, values, line, hover));
        const thin = { color: colors.muted, width: 1 };
        if (shown.length === 1) {
          /* For one case alone: its first profile, and the limit of friction on the traction. */
          add(`${name} first`, profiles[name][0], { ...thin, dash: "1px,2.5px" });
          if (name === "shear_traction" && friction !== null) {
            add("limit", profiles.pressure[snapshot].map((pressure) => pressure * friction), thin);
          }
        }
        const hover = `${key.toUpperCase()} %{y:.4~g} ${words[name].unit}<extra></extra>`;
        const line = { color: colors[key], width: 1.8, dash: DASH[key] };
        add(name, profiles[name][snapshot], line, hover);
      }
    });
    return { data: drawn, layout };
  }

  /* The highest value of a profile, of all snapshots or of the one shown. The gap, which grows
     without bound outside the contact, is scaled by what is in view of the last snapshot. */
  function highest(shown, name, right) {
    return largest(shown.flatMap(({ data, snapshot }) => {
      const { x, profiles } = lineOf(data);
      const now = profiles[name].at(ownScale.checked ? snapshot : -1);
      if (name === "gap") return now.filter((_, cell) => Math.abs(x[cell]) <= right);
      return ownScale.checked ? now : profiles[name].flat();
    }));
  }

  function zones({ key, data, snapshot }, row, yaxis) {
    const color = colors[key];
    const hatched = { shape: "/", fgcolor: color, bgcolor: colors.ground, size: 5, solidity: 0.3 };
    const markers = {
      stick: { color, line: { width: 0 } },
      slip: { color: colors.ground, line: { color, width: 0.75 }, pattern: hatched },
    };
    return Object.entries(markers).map(([state, marker]) => {
      const found = lineOf(data).zones[snapshot][state];
      return {
        type: "bar", orientation: "h", width: 0.72, xaxis: "x", yaxis, name: `${key} ${state}`,
        base: found.map(([from]) => from),
        x: found.map(([from, to]) => to - from),
        y: found.map(() => row),
        marker,
        hovertemplate: found.map(
          ([from, to]) =>
            `${state} from ${number(from)} to ${number(to)} ${words.x.unit}<extra></extra>`
        ),
      };
    });
  }

  /* The edges of stick zone and contact, through all panels. */
  function edges({ key, data, snapshot }, y1) {
    const color = colors[key];
    const tall = { yref: "paper", y0: 0, y1, layer: "below" };
    const { x, numbers } = lineOf(data);
    const [stick, contact] = ["stick", "contact"].map((zone) =>
      numbers[`${zone}_half_width_${along.value}`][snapshot]);
    return (x[0] < 0 ? [-1, 1] : [1]).flatMap((side) => [
      {
        type: "rect", x0: 0, x1: side * stick, fillcolor: color, opacity: 0.1, line: { width: 0 },
        ...tall,
      },
      {
        type: "line", x0: side * contact, x1: side * contact,
        line: { color, width: 1, dash: "dot" }, ...tall,
      },
    ]);
  }

  /* A field from above, of a contact that is not even, with its colour scale on top. */
  function mapFigure({ key, data: { view }, snapshot }, name, shown, width) {
    const [unit, font] = [words[name].unit, { color: colors.ink, size: 12 }];
    const all = shown.flatMap(({ data, snapshot }) =>
      (ownScale.checked ? [data.view.fields[name][snapshot]] : data.view.fields[name]).flat(2));
    const common = { showgrid: false, nticks: 5, constrain: "domain" };
    const y = axis(words.y.label, { ...common, scaleanchor: "x" });
    const margin = { l: 66, r: 12, t: 70, b: 44, autoexpand: false };
    const layout = panels(width + 36, axis(words.x.label, common), [y], { margin });
    const data = [{
      type: "heatmap", x: places(view.x), y: places(view.y), z: view.fields[name][snapshot],
      name: `${key} ${name}`,
      zmin: 0, zmax: largest(all) || 1, colorscale: DEPTHS,
      colorbar: {
        orientation: "h", x: 0, xanchor: "left", xpad: 0, len: 1, y: 1, yanchor: "bottom", ypad: 8,
        thickness: 10, outlinewidth: 0, nticks: 5, ticks: "outside", ticklen: 3,
        tickcolor: colors.muted, tickfont: { ...font, size: 11 },
        title: { text: `${key.toUpperCase()}: ${words[name].label}`, side: "top", font },
      },
      hovertemplate:
        `%{z:.4~g} ${unit} at x = %{x:.4~g}, y = %{y:.4~g} ${words.x.unit}<extra></extra>`,
    }];
    return { data, layout };
  }

  /* Bearing areas of rough contacts before and after wear. */
  function heightFigure(shown) {
    const x = axis(words.bearing_area.label, { range: [0, 100], hoverformat: ".3~g" });
    const share = (values) => values.map((_, place) => (100 * place) / (values.length - 1));
    const data = shown.flatMap(({ key, data: { heights } }) =>
      ["before", "after"].map((when, after) => curve(
      `${key} ${when}`, 0, share(heights[after]), heights[after],
      { color: colors[key], width: after ? 1.8 : 1.2, dash: after ? DASH[key] : "1px,2.5px" },
      `${key.toUpperCase()} ${when}: %{y:.4~g} ${words.height.unit}<extra></extra>`
    )));
    return { data, layout: panels(320, x, [axis(words.height.label)], { hovermode: "x" }) };
  }

  /* Panels of results over the cycles: every step as a line, snapshots as dots. */
  function historyFigure(shown, now) {
    const all = shown.flatMap(({ data }) => [...data.history.cycle, ...data.cycles]);
    const { position, gap, ...reached } = cycleAxis(all);
    const small = { color: colors.ink, size: 12 };
    const annotations = gap === undefined ? [] : [{
      x: gap, xref: "x", y: 0, yref: "paper", yanchor: "middle", text: "//",
      bgcolor: colors.ground, borderpad: 0, showarrow: false,
      font: { ...small, color: colors.muted },
    }];
    const data = study.histories.flatMap((names, place) => names.flatMap((name, lower) => {
      /* Names of curves that share a panel stand where they begin, the lower curve's below or, if
         the curves begin close together, where it ends. */
      const of = (one, at) => shown[0].data.history[one].at(at);
      const room = 0.15 * largest(names.flatMap((one) =>
        shown.flatMap(({ data }) => data.history[one])));
      const end = lower && of(names[0], 0) - of(name, 0) < room ? -1 : 0;
      const below = lower && of(name, end) > 0.5 * of(names[0], end);
      if (names.length > 1) annotations.push({
        x: position(of("cycle", end)), y: of(name, end), xref: "x", yref: "y",
        text: words[name].words.split(" ")[0], showarrow: false, font: small,
        xanchor: end ? "right" : "left", xshift: end ? -8 : 8,
        yanchor: below ? "top" : "bottom", yshift: below ? -2 : 2,
      });
      return shown.flatMap(({ key, snapshot, data: { history, cycles, numbers } }) => {
        const color = colors[key];
        const value =
          `%{y:.4~g} ${words[name].unit}<extra>${key.toUpperCase()}, ${words[name].words}</extra>`;
        const told = (cycle) => `cycle ${formatted(cycle)}: ${value}`;
        const drawn = (kind, at, values, line) =>
          curve(`${key} ${name}${kind}`, place, at.map(position), values, line, at.map(told));
        const shownOr = (is, not) => cycles.map((_, at) => (at === snapshot ? is : not));
        const line = { color, width: lower ? 1.2 : 2.2, dash: DASH[key] };
        return [
          drawn("", history.cycle, history[name], line),
          {
            ...drawn(" snapshots", cycles, numbers[name], {}),
            mode: "markers", customdata: cycles,
            marker: {
              color: shownOr(color, colors.ground), size: shownOr(11, 6), opacity: 1,
              line: { color, width: 1.5 },
            },
          },
        ];
      });
    }));
    const ys = study.histories.map((names) => {
      const { label } = words[names[0]];
      const common = label.replace(/^\S+ (.)/, (_, letter) => letter.toUpperCase());
      /* A longer label would leave its panel. */
      const short = label.length > 26 ? label.replace(" per ", "<br>per ") : label;
      return axis(names.length > 1 ? common : short, { rangemode: "tozero", nticks: 6 });
    });
    const layout = panels(420, axis(words.cycle.label, reached), ys, {
      hovermode: "closest",
      annotations,
      shapes: [{
        type: "line", x0: position(now), x1: position(now), yref: "paper", y0: 0, y1: 1,
        line: { color: colors.ink, width: 1.2 },
      }],
    });
    return { data, layout };
  }

  /* ---- Selecting cases: a control for each axis ---- */

  const selected = { a: study.start, b: null };
  const selects = {};
  let shown, cycles;
  let cycle = Infinity;
  let timer, started;

  function select(key, place) {
    selected[key] = place;
    selects[key].forEach((control, axis) => { control.value = points[place].index[axis]; });
  }

  /* A second case that differs from a point in as few and as late parameters as can be. */
  function neighbor(place) {
    const distance = ({ index }) =>
      index.reduce((sum, level, axis) => 2 * sum + (level !== points[place].index[axis]), 0);
    const others = points.filter((point) => point !== points[place] && point.data);
    others.sort((one, other) => distance(one) - distance(other));
    return points.indexOf(others[0] ?? points[place]);
  }

  /* ---- Drawing ---- */

  /* Draws what is selected, and says what cannot be shown. */
  function update() {
    const problems = [];
    shown = (compare.checked ? ["a", "b"] : ["a"]).flatMap((key) => {
      const point = points[selected[key]];
      if (point?.data) return { key, title: point.title, data: point.data };
      const why = point && `, point ${point.number}, is ${point.status}: ${point.reason}`;
      problems.push(`Case ${key.toUpperCase()}${why ?? " is not in this page."}`);
      return [];
    });
    status.textContent = problems.join(" ");
    status.hidden = !problems.length;
    cycles = [...new Set(shown.flatMap(({ data }) => data.cycles))].sort((a, b) => a - b);
    slider.max = Math.max(0, cycles.length - 1);
    slider.value = Math.max(0, cycles.findLastIndex((one) => one <= cycle));
    for (const control of [slider, play]) control.disabled = cycles.length < 2;
    get("case-b").hidden = !compare.checked;
    get("extras").hidden = shown.length !== 1;
    draw();
  }

  function draw() {
    const now = cycles[slider.value] ?? 0;
    get("cycle-shown").textContent = formatted(now);
    slider.setAttribute("aria-valuetext", `cycle ${formatted(now)}`);
    for (const one of shown) {
      one.snapshot = Math.max(0, one.data.cycles.findLastIndex((known) => known <= now));
    }
    get("readout").innerHTML = readout(now);
    for (const id of ["profile-plot", "history-plot"]) get(id).hidden = !shown.length;
    const [viewed, rough] = ["view", "heights"].map((one) => shown.filter(({ data }) => data[one]));
    get("maps").hidden = !viewed.length;
    get("heights").hidden = !rough.length;
    if (!shown.length) return;
    const style = getComputedStyle(document.body);
    colors = { font: style.fontFamily };
    for (const name of ["a", "b", "ground", "ink", "muted", "line"]) {
      colors[name] = style.getPropertyValue(`--${name}`);
    }
    const titles = shown.map(({ key, title }) => `case ${key.toUpperCase()}: ${title}`).join("; ");
    const told = (names) => names.map((name) => words[name].words).join(", ");
    remember(now);
    get("shown-cases").textContent = `After ${formatted(now)} cycles; ${titles}.`;
    const picture = (place, { data, layout }, label) => {
      Plotly.react(place, data, layout, CONFIG);
      place.setAttribute("aria-label", `${label}; ${titles}`);
    };
    const line = `Along ${along.value} after ${formatted(now)} cycles: ${told(study.profiles)}`;
    picture(get("profile-plot"), profileFigure(shown), line);
    const over = `Over the cycles: ${told(study.histories.flat())}`;
    picture(get("history-plot"), historyFigure(shown, now), over);
    const maps = viewed.flatMap((one) => study.maps.map((name) => [one, name]));
    [...get("maps").querySelectorAll(".plot")].forEach((place, at) => {
      place.hidden = at >= maps.length;
      if (place.hidden) return;
      const [one, name] = maps[at];
      const map = mapFigure(one, name, viewed, place.clientWidth);
      picture(place, map, `From above: ${words[name].words}`);
    });
    if (!rough.length) return;
    picture(get("height-plot"), heightFigure(rough), "Bearing areas before and after wear");
  }

  function readout(now) {
    const row = (name, texts) =>
      `<tr><th scope="row">${name}</th><td>${texts.join("</td><td>")}</td></tr>`;
    const rows = study.readout.map((name) => {
      const values = shown.map(({ data, snapshot }) => data.numbers[name][snapshot]);
      const known = values[0] > 0 && values[1] !== null;
      const ratio = known ? `× ${number(values[1] / values[0], 3)}` : "–";
      const texts = values.map((value) => number(value));
      return row(words[name].label, values.length === 2 ? [...texts, ratio] : texts);
    });
    const reached = shown.map(({ data, snapshot }) => data.cycles[snapshot]);
    if (reached.some((one) => one !== now)) {
      rows.unshift(row("Last snapshot until then", reached.map((one) => formatted(one))));
    }
    const names = shown.map(({ key }) => key.toUpperCase());
    if (names.length === 2) names.push("B to A");
    const heads = names.map((text) => `<th scope="col">${text}</th>`);
    return `<caption>After ${formatted(now)} cycles</caption><thead><tr><td></td>${
      heads.join("")}</tr></thead><tbody>${rows.join("")}</tbody>`;
  }

  /* ---- The address of what is shown: #case=3&with=4&cycle=1000 ---- */

  function remember(cycle) {
    const asked = new URLSearchParams();
    const told = { case: points[selected.a], with: compare.checked && points[selected.b] };
    for (const name in told) if (told[name]) asked.set(name, told[name].number);
    asked.set("cycle", cycle);
    if (along.value === "y") asked.set("along", "y");
    const address = `#${asked}`;
    if (started && location.hash !== address) window.history.replaceState(null, "", address);
  }

  /* Shows what an address asks for, if it is one of the explorer. */
  function recall() {
    const asked = new URLSearchParams(location.hash.slice(1));
    const [one, other] = ["case", "with"].map((name) =>
      points.findIndex(({ number }) => String(number) === asked.get(name)));
    if (one < 0) return;
    select("a", one);
    compare.checked = other >= 0;
    if (compare.checked) select("b", other);
    if (asked.has("cycle")) cycle = Number(asked.get("cycle"));
    along.value = asked.get("along") === "y" && !along.parentElement.hidden ? "y" : "x";
    update();
    get("explorer").scrollIntoView();
  }

  /* ---- Moving through the cycles ---- */

  function go(place) {
    slider.value = place;
    cycle = cycles[place];
    draw();
  }

  const atEnd = () => Number(slider.value) === cycles.length - 1;

  function setPlaying(yes) {
    clearInterval(timer);
    timer = yes && setInterval(() => {
      if (!atEnd()) go(Number(slider.value) + 1);
      if (atEnd()) setPlaying(false);
    }, PAUSE);
    play.querySelector(".words").textContent = yes ? "Pause" : "Play";
    play.firstElementChild.textContent = yes ? "❚❚" : "▶";
  }

  slider.addEventListener("input", () => {
    if (timer) setPlaying(false);
    go(Number(slider.value));
  });
  play.addEventListener("click", () => {
    if (!timer && atEnd()) go(0);
    setPlaying(!timer);
  });
  for (const control of [ownScale, along]) control.addEventListener("change", draw);
  compare.addEventListener("change", () => {
    if (selected.b === null) select("b", neighbor(Math.max(0, selected.a)));
    update();
  });

  /* ---- The page around it ---- */

  for (const key of ["a", "b"]) {
    selects[key] = [...document.querySelectorAll(`#case-${key} select`)];
    get(`case-${key}`).addEventListener("change", () => {
      const index = selects[key].map(({ value }) => value).join();
      selected[key] = points.findIndex((point) => point.index.join() === index);
      update();
    });
  }
  get("explorer-body").hidden = false;
  compare.parentElement.hidden = points.length < 2;
  along.parentElement.hidden = !study.cases.every(({ across }) => across);
  select("a", study.start);
  update();
  recall();
  started = true;
  addEventListener("hashchange", recall);
  for (const media of ["(prefers-color-scheme: dark)", "print"]) {
    matchMedia(media).addEventListener("change", draw);
  }
  get("history-plot").on("plotly_click", ({ points: [clicked] }) => {
    const place = cycles.indexOf(clicked.customdata);
    if (place >= 0) go(place);
  });
  document.documentElement.dataset.explorer = "ready";
})();
