// Numbers as text.
"use strict";
globalThis.Words = (() => {
  const SPACE = "\u00a0"; // between a number and its unit, where no line may break

  function digits(value, count = 4) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size >= 1e-3 && size < 1e5) {
      const plain = Number(value.toPrecision(count)) === Math.round(value) && size >= 1000
        ? String(Math.round(value)) : value.toPrecision(count);
      return (plain.includes("e") ? String(Number(plain)) : plain).replace("-", "−");
    }
    const [mantissa, power] = value.toExponential(count - 1).split("e");
    const raised = [...power.replace("+", "")].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("");
    return `${mantissa}×10${raised}`.replace("-", "−");
  }

  function withUnit(value, unit, steps = { "": 1 }) {
    const fitting = Object.entries(steps).filter(([, one]) => Math.abs(value) >= one * 0.9995);
    const [prefix, one] = fitting[0] ?? Object.entries(steps).at(-1);
    return value === 0 ? `0${SPACE}${unit}` : `${digits(value / one)}${SPACE}${prefix}${unit}`;
  }

  const speedText = (v) => (v >= 0.01 ? `${digits(v)}${SPACE}m/s` : withUnit(v, "m/s", { m: 1e-3, µ: 1e-6 }));
  const SECONDS = { "": 1, m: 1e-3, µ: 1e-6, n: 1e-9 };
  const timeText = (t) => (Number.isFinite(t) ? withUnit(t, "s", SECONDS) : "does not leave");
  const spinText = (w) => withUnit(w, "rad/s");

  function captureText(value) {
    if (value === 0) return "none";
    return value === Infinity ? "infinite: no speed rebounds" : speedText(value);
  }

  return { digits, speedText, timeText, spinText, captureText };
})();
