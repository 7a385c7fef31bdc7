"use strict";
/* What plotly is to draw: traces and layouts of the profiles and of the histories. */
(function () {
  const { number, cycleNumber, cycleAxis } = window.fretwear;
  const PANELS = [
    { name: "pressure", label: "Pressure" },
    { name: "shear", label: "Shear traction" },
    { name: "gap", label: "Gap" },
    { name: "wear", label: "Wear depth" },
  ];
  const BEYOND_CONTACT = 1.12;
  const HEADROOM = 1.06;

  function palette() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue("--" + name).trim();
    return {
      ground: color("ground"),
      ink: color("ink"),
      muted: color("muted"),
      line: color("line"),
      a: color("series-a"),
      b: color("series-b"),
      font: getComputedStyle(document.body).fontFamily,
    };
  }

  const dashOf = { a: "solid", b: "6px,3px" };

  function base(colors, width) {
    return {
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: colors.font, size: width < 480 ? 12 : 13, color: colors.ink },
      showlegend: false,
      separators: ".\u2009",
      hoverlabel: { bgcolor: colors.ground, bordercolor: colors.muted, font: { color: colors.ink } },
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
      margin: { l: 66, r: 12, t: 6, b: 44 },
    };
  }

  const title = (text) => ({ text, standoff: 6, font: { size: 12 } });

  function axis(colors, more) {
    return {
      color: colors.ink,
      gridcolor: colors.line,
      linecolor: colors.muted,
      showline: true,
      zeroline: false,
      ticks: "outside",
      ticklen: 4,
      tickcolor: colors.muted,
      separatethousands: false,
      exponentformat: "none",
      ...more,
    };
  }

  const largest = (values) => values.reduce((most, one) => (one > most ? one : most), 0);

  /* Limits of the profiles' axes: those of all snapshots, or of the one shown. */
  function frame(shown, own) {
    const right = BEYOND_CONTACT * largest(shown.flatMap((one) => one.data.scalars.contact));
    const tops = {};
    for (const { name } of PANELS) {
      tops[name] = largest(
        shown.flatMap(({ data, snapshot }) => {
          const last = data.cycles.length - 1;
          const from = own ? [snapshot] : name === "gap" ? [last] : data.cycles.keys();
          return Array.from(from).flatMap((place) =>
            data.profile(name, place).filter((_, index) => data.x[index] <= right)
          );
        })
      );
    }
    return { right, tops };
  }

  function domains(count, rows) {
    const strip = 0.03 * rows;
    const between = 0.03;
    const height = (1 - strip - count * between) / count;
    const panels = Array.from({ length: count }, (_, place) => {
      const top = 1 - strip - between - place * (height + between);
      return [Math.max(0, top - height), top];
    });
    return { strip: [1 - strip, 1], panels };
  }

  function zoneTraces(one, row, colors) {
    const common = {
      type: "bar",
      orientation: "h",
      xaxis: "x",
      yaxis: "y5",
      width: 0.72,
    };
    return ["stick", "slip"].map((state) => {
      const zones = one.data.zones(state, one.snapshot);
      const words = state === "stick" ? "sticks" : "slips";
      const marker =
        state === "stick"
          ? { color: colors[one.key], line: { width: 0 } }
          : {
              color: colors.ground,
              line: { color: colors[one.key], width: 0.75 },
              pattern: { shape: "/", fgcolor: colors[one.key], bgcolor: colors.ground, size: 5, solidity: 0.3 },
            };
      return {
        ...common,
        name: one.key + " " + state,
        base: zones.map((zone) => zone[0]),
        x: zones.map((zone) => zone[1] - zone[0]),
        y: zones.map(() => row),
        marker,
        hovertemplate: zones.map(
          (zone) => `${words} from ${number(zone[0])} to ${number(zone[1])} µm<extra></extra>`
        ),
      };
    });
  }

  function line(one, name, values, yaxis, style, more) {
    return {
      type: "scatter",
      mode: "lines",
      name: one.key + " " + name,
      x: one.data.x,
      y: values,
      xaxis: "x",
      yaxis,
      line: style,
      ...more,
    };
  }

  /* For one case alone: what it was at first, and the friction bound of the shear traction. */
  function references(one, name, yaxis, colors) {
    const quiet = { hoverinfo: "skip" };
    const dotted = { color: colors.muted, width: 1, dash: "1px,2.5px" };
    const found = [line(one, name + " first", one.data.profile(name, 0), yaxis, dotted, quiet)];
    if (name === "shear") {
      const bound = one.data.profile("pressure", one.snapshot).map((p) => p * one.data.friction);
      const solid = { color: colors.muted, width: 1 };
      found.push(line(one, "bound", bound, yaxis, solid, quiet));
    }
    return found;
  }

  function profiles(shown, units, own, width) {
    const colors = palette();
    const { right, tops } = frame(shown, own);
    const { strip, panels } = domains(PANELS.length, shown.length);
    const data = shown.flatMap((one, place) => zoneTraces(one, shown.length - 1 - place, colors));
    const layout = {
      ...base(colors, width),
      barmode: "overlay",
      hovermode: "x",
      hoversubplots: "axis",
      height: 720 + 20 * shown.length,
      xaxis: axis(colors, {
        title: title(`x (${units.x})`),
        range: [0, right],
        anchor: "y4",
        hoverformat: ".4~g",
      }),
      yaxis5: {
        domain: strip,
        range: [-0.5, shown.length - 0.5],
        tickvals: shown.map((_, place) => shown.length - 1 - place),
        ticktext: shown.map((one) => one.key.toUpperCase()),
        ticklabelstandoff: 5,
        fixedrange: true,
        showgrid: false,
        zeroline: false,
        color: colors.ink,
      },
      shapes: shown.flatMap((one) => edges(one, panels, colors)),
    };
    PANELS.forEach(({ name, label }, place) => {
      const yaxis = place ? "y" + (place + 1) : "y";
      const top = HEADROOM * (tops[name] || 1);
      layout["yaxis" + (place ? place + 1 : "")] = axis(colors, {
        domain: panels[place],
        title: title(`${label} (${units[name]})`),
        range: name === "wear" ? [top, 0] : [0, top],
        nticks: 5,
      });
      for (const one of shown) {
        if (shown.length === 1) data.push(...references(one, name, yaxis, colors));
        const style = { color: colors[one.key], width: 1.8, dash: dashOf[one.key] };
        const hover = `${one.key.toUpperCase()} %{y:.4~g} ${units[name]}<extra></extra>`;
        const values = one.data.profile(name, one.snapshot);
        data.push(line(one, name, values, yaxis, style, { hovertemplate: hover }));
      }
    });
    return { data, layout };
  }

  /* The edges of stick zone and contact, through all panels. */
  function edges(one, panels, colors) {
    const [stick, contact] = ["stick", "contact"].map((n) => one.data.scalars[n][one.snapshot]);
    const tall = { yref: "paper", y0: panels[panels.length - 1][0], y1: panels[0][1], layer: "below" };
    const color = colors[one.key];
    return [
      { type: "rect", x0: 0, x1: stick, fillcolor: color, opacity: 0.1, line: { width: 0 }, ...tall },
      { type: "line", x0: contact, x1: contact, line: { color, width: 1, dash: "dot" }, ...tall },
    ];
  }

  function histories(shown, units, cycle, width) {
    const colors = palette();
    const reached = cycleAxis(
      shown.flatMap((one) => [...one.data.history.cycle, ...one.data.cycles])
    );
    const at = reached.position(cycle);
    const xaxis = axis(colors, {
      title: title("Cycle"),
      range: reached.range,
      anchor: "y2",
      ...reached.ticks,
    });
    const layout = {
      ...base(colors, width),
      hovermode: "closest",
      height: 420,
      xaxis,
      yaxis: axis(colors, {
        domain: [0.54, 1],
        rangemode: "tozero",
        title: title(`Half-width (${units.contact})`),
        nticks: 6,
      }),
      yaxis2: axis(colors, {
        domain: [0, 0.46],
        rangemode: "tozero",
        title: title(`Wear volume (${units.volume})`),
        nticks: 6,
      }),
      shapes: [
        { type: "line", x0: at, x1: at, yref: "paper", y0: 0, y1: 1, line: { color: colors.ink, width: 1.2 } },
      ],
      annotations: [...names(shown[0], reached, colors), ...breaks(reached, colors)],
    };
    const data = shown.flatMap((one) => [
      ...history(one, "contact", "y", 2.2, reached, units, colors),
      ...history(one, "stick", "y", 1.2, reached, units, colors),
      ...history(one, "volume", "y2", 2.2, reached, units, colors),
    ]);
    return { data, layout };
  }

  const WORDS = { contact: "contact", stick: "stick zone", volume: "wear volume" };

  function history(one, name, yaxis, width, reached, units, colors) {
    const color = colors[one.key];
    const { history: steps, cycles, scalars } = one.data;
    const words = `${one.key.toUpperCase()}, ${WORDS[name]}`;
    const template = (cycle) => `cycle ${cycleNumber(cycle)}: %{y:.4~g} ${units[name]}<extra>${words}</extra>`;
    const common = { type: "scatter", xaxis: "x", yaxis };
    return [
      {
        ...common,
        mode: "lines",
        name: `${one.key} ${name}`,
        x: steps.cycle.map(reached.position),
        y: steps[name],
        line: { color, width, dash: dashOf[one.key] },
        hovertemplate: steps.cycle.map(template),
      },
      {
        ...common,
        mode: "markers",
        name: `${one.key} ${name} snapshots`,
        x: cycles.map(reached.position),
        y: scalars[name],
        customdata: cycles,
        marker: {
          color: cycles.map((_, place) => (place === one.snapshot ? color : colors.ground)),
          size: cycles.map((_, place) => (place === one.snapshot ? 11 : 6)),
          line: { color, width: 1.5 },
          opacity: 1,
        },
        hovertemplate: cycles.map(template),
      },
    ];
  }

  /* Names of the two half-widths at their curves, in the first case. */
  function names(one, reached, colors) {
    const { cycle, contact, stick } = one.data.history;
    const apart = stick[0] > 0.5 * contact[0];
    return [
      ["contact", contact, "bottom"],
      ["stick zone", stick, apart ? "top" : "bottom"],
    ].map(([text, values, yanchor]) => ({
      x: reached.position(cycle[0]),
      y: values[0],
      xref: "x",
      yref: "y",
      text,
      xanchor: "left",
      yanchor,
      xshift: 8,
      yshift: yanchor === "bottom" ? 2 : -2,
      showarrow: false,
      font: { color: colors.ink, size: 12 },
    }));
  }

  function breaks(reached, colors) {
    if (reached.gap === undefined) return [];
    return [
      {
        x: reached.gap,
        xref: "x",
        y: 0,
        yref: "paper",
        yanchor: "middle",
        text: "//",
        bgcolor: colors.ground,
        borderpad: 0,
        showarrow: false,
        font: { color: colors.muted, size: 12 },
      },
    ];
  }

  Object.assign(window.fretwear, { profiles, histories });
})();
