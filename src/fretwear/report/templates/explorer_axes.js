"use strict";
/* Numbers as people read them, and an axis of cycles that is logarithmic and still shows 0. */
(function () {
  const ZERO_GAP = 0.7;
  const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

  function superscript(power) {
    const digits = String(Math.abs(power)).replace(/\d/g, (digit) => SUPERSCRIPTS[digit]);
    return (power < 0 ? "⁻" : "") + digits;
  }

  function number(value, digits = 4) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size < 1e-3 || size >= 1e7) {
      const [mantissa, power] = value.toExponential(digits - 1).split("e");
      return mantissa + " × 10" + superscript(Number(power));
    }
    const text = size >= 10 ** digits ? String(Math.round(value)) : value.toPrecision(digits);
    return text.replace("-", "−");
  }

  function cycleNumber(value) {
    const text = String(Math.round(value));
    return value >= 10000 ? text.replace(/\B(?=(\d{3})+$)/g, "\u2009") : text;
  }

  /* Maps cycles to positions; says where the ticks are and which range to show. */
  function cycleAxis(cycles) {
    const last = Math.max(...cycles);
    const positive = cycles.filter((cycle) => cycle > 0);
    const first = Math.max(1, Math.min(...positive));
    if (!positive.length || last < 10 * first) {
      const margin = 0.04 * (last || 1);
      return { position: (cycle) => cycle, range: [-margin, last + margin], ticks: {} };
    }
    const zero = Math.log10(first) - ZERO_GAP;
    const position = (cycle) =>
      cycle >= first ? Math.log10(cycle) : zero + (ZERO_GAP * cycle) / first;
    const powers = [];
    for (let power = Math.ceil(Math.log10(first)); 10 ** power <= last; power += 1) {
      powers.push(power);
    }
    const words = (power) => (power < 4 ? String(10 ** power) : "10" + superscript(power));
    return {
      position,
      range: [zero - 0.08, Math.log10(last) + 0.1],
      ticks: { tickvals: [zero, ...powers], ticktext: ["0", ...powers.map(words)] },
      gap: zero + 0.5 * ZERO_GAP,
    };
  }

  Object.assign(window.fretwear, { number, cycleNumber, cycleAxis });
})();
