// Small plots, as SVG. They know numbers, not physics.
"use strict";
globalThis.Plots = (() => {
  const SVG = "http://www.w3.org/2000/svg";
  const [WIDTH, HEIGHT] = [440, 290];
  const FRAME = { left: 66, right: 14, top: 16, bottom: 44 };

  function element(name, attributes = {}, text = "") {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text) made.textContent = text;
    return made;
  }

  function ticksOf({ low, high, log, step }) {
    const found = [];
    if (log) {
      const decades = Math.log10(high / low);
      const digits = decades > 3 ? [1] : decades > 1.6 ? [1, 3] : [1, 2, 5];
      for (let k = Math.floor(Math.log10(low)); k <= Math.ceil(Math.log10(high)); k += 1) {
        found.push(...digits.map((digit) => Number(`${digit}e${k}`)));
      }
      return found.filter((x) => x >= low * 0.999 && x <= high * 1.001);
    }
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high * (1 + 1e-9) + 1e-12; i += 1) {
      found.push(Number((i * step).toPrecision(12)));
    }
    return found;
  }

  /** A step of 1, 2 or 5 times a power of ten that divides a span into about `parts`. */
  function niceStep(span, parts = 5) {
    const unit = 10 ** Math.floor(Math.log10(span / parts));
    return unit * ([1, 2, 5, 10].find((k) => k * unit * parts >= span * 0.999) ?? 10);
  }

  function tickText(value) {
    const size = Math.abs(value);
    if (value !== 0 && (size < 1e-3 || size >= 1e4)) {
      const power = Math.round(Math.log10(size) - 0.4999);
      const digit = Number((value / 10 ** power).toPrecision(2));
      const raised = [...String(power)].map((c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻").join("");
      return digit === 1 ? `10${raised}` : `${digit}×10${raised}`;
    }
    return String(value).replace("-", "−");
  }

  /** Draw a plot: axes x and y {low, high, label, log, step}, then `layers` in order. */
  function chart(svg, { x, y, label }, layers) {
    const inner = { w: WIDTH - FRAME.left - FRAME.right, h: HEIGHT - FRAME.top - FRAME.bottom };
    const part = ({ low, high, log }, value) =>
      log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
    const px = (value) => FRAME.left + inner.w * part(x, value);
    const py = (value) => FRAME.top + inner.h * (1 - part(y, value));
    const [right, bottom] = [FRAME.left + inner.w, FRAME.top + inner.h];
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    svg.setAttribute("aria-label", label);
    svg.replaceChildren();
    const grid = element("g", { class: "grid" });
    for (const value of ticksOf(y)) {
      grid.append(element("line", { x1: FRAME.left, x2: right, y1: py(value), y2: py(value) }));
      const at = { x: FRAME.left - 7, y: py(value) + 4, "text-anchor": "end" };
      grid.append(element("text", at, tickText(value)));
    }
    for (const value of ticksOf(x)) {
      grid.append(element("line", { x1: px(value), x2: px(value), y1: bottom, y2: bottom + 5 }));
      const at = { x: px(value), y: bottom + 18, "text-anchor": "middle" };
      grid.append(element("text", at, tickText(value)));
    }
    grid.append(element("line", { class: "base", x1: FRAME.left, x2: right, y1: bottom, y2: bottom }));
    svg.append(grid);
    const title = { x: FRAME.left + inner.w / 2, y: HEIGHT - 6, "text-anchor": "middle", class: "axis" };
    svg.append(element("text", title, x.label));
    const middle = FRAME.top + inner.h / 2;
    const upright = { x: 16, y: middle, transform: `rotate(-90 16 ${middle})`, "text-anchor": "middle", class: "axis" };
    svg.append(element("text", upright, y.label));
    for (const layer of layers) drawLayer(svg, layer, px, py, { ...FRAME, bottom, w: inner.w });
  }

  function drawLayer(svg, layer, px, py, frame) {
    const { kind, className = "" } = layer;
    if (kind === "band") {
      const [from, to] = [px(layer.from), px(layer.to)];
      const [width, height] = [Math.max(to - from, 0), frame.bottom - frame.top];
      svg.append(element("rect", { x: from, y: frame.top, width, height, class: "band" }));
      if (layer.text && to - from > 70) {
        svg.append(element("text", { x: from + 8, y: frame.top + 16, class: "note" }, layer.text));
      }
    } else if (kind === "curve") {
      const points = layer.points.map(([a, b]) => `${px(a).toFixed(2)},${py(b).toFixed(2)}`);
      const line = { points: points.join(" "), class: `curve ${className}` };
      if (points.length > 1) svg.append(element("polyline", line));
    } else if (kind === "upright") {
      const at = px(layer.at);
      const left = at > frame.left + frame.w * 0.6;
      const place = { x: at + (left ? -6 : 6), y: frame.bottom - 8, class: "note" };
      svg.append(element("line", { x1: at, x2: at, y1: frame.top, y2: frame.bottom, class: "upright" }));
      svg.append(element("text", { ...place, "text-anchor": left ? "end" : "start" }, layer.text));
    } else if (kind === "point") {
      const [cx, cy] = [px(layer.at[0]), py(layer.at[1])];
      svg.append(element("circle", { cx, cy, r: 6, class: `point ${className}` }));
    }
  }

  function clear(svg) {
    svg.replaceChildren();
    svg.setAttribute("aria-label", "Nothing to show");
  }

  return { chart, clear, niceStep };
})();
