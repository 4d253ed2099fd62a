// What each picture shows: the present impact among its neighbours in speed and in angle.
"use strict";
globalThis.Views = (() => {
  const { impact } = Explorer;
  const { digits, speedText } = Words;

  function restitution(svg, c, scale, found, limit) {
    const vc = Number.isFinite(limit) ? limit : 0;
    const now = found.normal_speed;
    const low = vc > 0 ? Math.min(vc / 3, now / 1.5) : now / 30;
    const high = Math.max(now * 3, vc > 0 ? 12 * vc : 30 * now);
    const from = Math.min(Math.max(limit, low), high);
    const points = Array.from({ length: from < high ? 140 : 0 }, (_, i) => {
      const v = from * (high / from) ** ((i / 139) ** 2);
      const outcome = impact({ ...c, speed: v, angle: 90, spin: 0 }, scale);
      return outcome.unsolved ? null : [v, outcome.coefficient_of_restitution];
    }).filter(Boolean);
    const layers = [];
    if (from > low) layers.push({ kind: "band", from: low, to: from, text: "captured" });
    layers.push({ kind: "curve", points, className: "main" });
    if (vc > 0) layers.push({ kind: "upright", at: vc, text: `capture velocity ${speedText(vc)}` });
    const e = found.coefficient_of_restitution;
    layers.push({ kind: "point", at: [now, e], className: found.captured ? "captured" : "" });
    const axes = {
      x: { low, high, log: true, label: "normal speed, m/s" },
      y: { low: 0, high: 1, step: 0.2, label: "restitution e" },
      label: `Coefficient of restitution against normal speed; here ${digits(e, 3)} at ${speedText(now)}.`,
    };
    Plots.chart(svg, axes, layers);
  }

  function angles(svgs, c, scale, found, limit) {
    const steps = Array.from({ length: 180 }, (_, i) => (i + 1) / 2);
    const sweep = steps
      .map((angle) => [angle, impact({ ...c, angle }, scale)])
      .filter(([, o]) => !o.unsolved);
    const critical = (Math.asin(Math.min(limit / c.speed, 1)) * 180) / Math.PI;
    const band = { kind: "band", from: 0, to: critical, text: "captured" };
    const mark = found.captured ? "captured" : "";
    const x = { low: 0, high: 90, step: 15, label: "angle from the surface, degrees" };
    const draw = (svg, columns, floor, ceiling, axis, name) => {
      const rebounds = sweep.filter(([, o]) => !o.captured);
      const all = [found, ...rebounds.map(([, o]) => o)].flatMap((o) => columns.map(([key]) => o[key]));
      const low = Math.min(floor, ...all);
      const high = Math.max(ceiling, ...all);
      const step = Plots.niceStep(high - low || 1);
      const y = {
        low: Math.floor(low / step + 1e-9) * step,
        high: Math.ceil(high / step - 1e-9) * step,
        step,
        label: axis,
      };
      const curves = columns.flatMap(([key, className]) => [true, false].map((captured) => ({
        kind: "curve",
        className: captured ? `${className} captured` : className,
        points: sweep
          .filter(([, o]) => o.captured === captured && o[key] >= y.low && o[key] <= y.high)
          .map(([a, o]) => [a, o[key]]),
      })));
      const dots = columns.map(([key, className]) => ({
        kind: "point",
        at: [c.angle, found[key]],
        className: `${mark} ${className}`,
      }));
      const here = columns.map(([key]) => digits(found[key], 3)).join(" and ");
      const label = `${name} against the angle; here ${here} at ${digits(c.angle, 3)} degrees.`;
      const layers = [...(band.to > 0.3 ? [band] : []), ...curves, ...dots.reverse()];
      Plots.chart(svg, { x, y, label }, layers);
    };
    const losses = [["energy_loss", "main"], ["translational_energy_loss", "second"]];
    const roof = Math.max(c.friction * 1.1, 1e-3);
    draw(svgs.ratio, [["impulse_ratio", "main"]], 0, roof, "impulse ratio −μ", "Impulse ratio");
    draw(svgs.loss, losses, 0, 1, "share of the energy lost", "Energy loss, total and of translation,");
  }

  return { restitution, angles };
})();
