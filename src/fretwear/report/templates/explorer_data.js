"use strict";
/* The explorer's data: packed by fretwear.report.explorer, unpacked here. */
(function () {
  const MISSING = -32768;
  const STATES = { open: 0, slip: 1, stick: 2 };

  async function unpacked(id) {
    const text = atob(document.getElementById(id).textContent.trim());
    const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  /* One case: profiles over x and histories over the cycles, in the units of the header. */
  class Case {
    constructor(packed, buffer, start) {
      const [first, spacing, count] = packed.x;
      this.id = packed.id;
      this.friction = packed.friction;
      this.cycles = packed.cycles;
      this.scalars = packed.scalars;
      this.x = Array.from({ length: count }, (_, place) => first + place * spacing);
      this.packed = packed;
      this.buffer = buffer;
      this.start = start;
      const steps = packed.steps;
      this.history = {};
      for (const name of ["cycle", "contact", "stick", "volume"]) {
        this.history[name] = Array.from(
          new Float32Array(buffer, start + steps[name], steps.number)
        );
      }
    }

    /* Place of the last snapshot that is not after a cycle. */
    snapshot(cycle) {
      let place = 0;
      this.cycles.forEach((one, index) => {
        if (one <= cycle) place = index;
      });
      return place;
    }

    profile(name, snapshot) {
      const { at, scales } = this.packed.profiles[name];
      const count = this.x.length;
      const row = new Int16Array(this.buffer, this.start + at + 2 * snapshot * count, count);
      return Array.from(row, (whole) => (whole === MISSING ? null : whole * scales[snapshot]));
    }

    /* Stretches of x in which every cell has one state: pairs of where it begins and ends. */
    zones(state, snapshot) {
      const [first, spacing] = this.packed.x;
      const found = [];
      let edge = first - 0.5 * spacing;
      const runs = this.packed.states[snapshot];
      for (let place = 0; place < runs.length; place += 2) {
        const end = edge + runs[place + 1] * spacing;
        if (runs[place] === STATES[state]) found.push([edge, end]);
        edge = end;
      }
      return found;
    }
  }

  async function study() {
    const buffer = await unpacked("explorer-data");
    const length = new DataView(buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
    const cases = header.cases.map((packed) => new Case(packed, buffer, 8 + length));
    const points = header.points.map((point) => ({
      ...point,
      data: point.case < 0 ? null : cases[point.case],
    }));
    return { ...header, cases, points };
  }

  async function plotly() {
    const script = document.createElement("script");
    script.textContent = new TextDecoder().decode(await unpacked("plotly-source"));
    document.head.append(script);
    if (typeof Plotly === "undefined") throw new Error("plotly did not start");
  }

  window.fretwear = { study, plotly };
})();
