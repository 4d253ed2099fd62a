// One impact: the normal motion by interpolation in the tables of the page, all else in closed form.
// SI units. The tables and their coordinates are described where they are made, in the study
// `explorer_tables`; equation numbers are the article's.
"use strict";
globalThis.Explorer = (() => {
  const numbers = JSON.parse(document.getElementById("numbers").textContent);
  const { largest_damping, threshold_exponent, impulse_exponent, slow_passage } = numbers.constants;
  const { inertia, hopeless_hertz_group, hopeless_adhesion_group } = numbers.constants;
  const slipPerImpulse = 1 + 1 / inertia;

  // ---- tables -------------------------------------------------------------------------------
  function decoded(text, Numbers) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Numbers(bytes.buffer);
  }

  function table({ axes, precision, columns }) {
    const Numbers = precision === "double" ? Float64Array : Float32Array;
    const values = Object.entries(columns).map(([name, text]) => [name, decoded(text, Numbers)]);
    return { axes, values: Object.fromEntries(values) };
  }

  const tables = Object.fromEntries(
    Object.entries(numbers.tables).map(([name, stored]) => [name, table(stored)]),
  );

  /** Barycentric weights of Chebyshev nodes of the first kind at one point. */
  function nodeWeights(nodes, at) {
    const n = nodes.length;
    let total = 0;
    const weights = nodes.map((node, k) => {
      const distance = at - node || Number.MIN_VALUE * 2 ** 53;
      const weight = ((k % 2 ? -1 : 1) * Math.sin(((2 * k + 1) * Math.PI) / (2 * n))) / distance;
      total += weight;
      return weight;
    });
    return weights.map((weight) => weight / total);
  }

  /** All columns of a table at one point: the tensor of node values against the weights. */
  function lookUp({ axes, values }, at) {
    const weights = axes.map((nodes, i) => nodeWeights(nodes, at[i]));
    const last = weights.at(-1);
    const rest = weights.slice(0, -1).reduce((a, b) => a.flatMap((x) => b.map((y) => x * y)), [1]);
    const found = {};
    for (const [name, column] of Object.entries(values)) {
      let sum = 0;
      let k = 0;
      for (const weight of rest) {
        let row = 0;
        for (const w of last) row += w * column[k++];
        sum += weight * row;
      }
      found[name] = sum;
    }
    return found;
  }

  // ---- normal motion ------------------------------------------------------------------------
  /** Stiffness (20, 21), ring force (30) and the scales of a contact. */
  function scales(c) {
    const compliance = (body) => (1 - body.poissons_ratio ** 2) / (Math.PI * body.youngs_modulus);
    const radius = c.diameter / 2;
    const stiffness = 4 / (3 * Math.PI * (compliance(c.particle) + compliance(c.surface)));
    const mass = (c.particle.density * Math.PI * c.diameter ** 3) / 6;
    const ring = Math.cbrt((9 * stiffness * radius * c.work_of_adhesion ** 2) / (2 * Math.PI));
    const spring = Math.sqrt(radius) * stiffness;
    const equilibrium = (2 * Math.PI * ring) / stiffness;
    const velocity = Math.sqrt((spring * equilibrium ** 2.5) / mass);
    return { radius, stiffness, mass, ring_force: ring, spring, velocity };
  }

  /** Damping D of an impact at a normal speed, and the share of Hertz damping in it. */
  function damping(c, speed) {
    const ratio = c.adhesion_rate_exponent ? c.reference_velocity / speed : 1;
    const adhesion = c.adhesion_damping * speed * ratio ** c.adhesion_rate_exponent;
    const hertz = 2 * c.hertz_damping * speed;
    const total = adhesion + hertz;
    return { total, share: total > 0 ? hertz / total : 0 };
  }

  /** Speed at the threshold of capture, in velocity scales. */
  function threshold({ total, share }) {
    if (total === 0) return 0;
    const at = [(total / largest_damping) ** threshold_exponent, Math.sqrt(share)];
    return Math.cbrt(total) * lookUp(tables.threshold, at).scaled_threshold;
  }

  const strengthOf = (scaledSpeed) => scaledSpeed ** -0.8;

  /** Outcome of a normal impact, impulses per mass; `outside` where the tables do not reach. */
  function normalImpact(c, scale, speed) {
    const lost = damping(c, speed);
    if (!(lost.total <= largest_damping)) return { outside: true, damping: lost };
    const scaled = speed / scale.velocity;
    const limit = threshold(lost);
    if (scaled <= limit) return { captured: true, e: 0, damping: lost, contact_time: Infinity };
    const b = strengthOf(scaled);
    const closeness = lost.total > 0 ? Math.sqrt(Math.max(1 - b / strengthOf(limit), 0)) : 1;
    // 1/b at the threshold is 0 without damping.
    const freedom = lost.total > 0 ? 1 / strengthOf(limit) : 0;
    const ratio = (b * (1 + freedom)) / (1 + b);
    const relative = lost.total / largest_damping;
    const root = Math.sqrt(lost.share);
    const rebound = lookUp(tables.restitution, [relative ** threshold_exponent, root, closeness]);
    const place = [relative ** impulse_exponent, root, Math.max(1 - ratio, 0) ** 0.25];
    const impulses = lookUp(tables.impulses, place);
    const e = lost.total > 0 ? Math.min(closeness * rebound.scaled_restitution, 1) : 1;
    const depth = 1 + b ** 2.5;
    const slow = slow_passage * depth ** (-1 / 6) * (1 + Math.cbrt(e));
    const hertzTime = ((scale.mass * speed ** 2) / scale.spring) ** 0.4 / speed;
    const hertzWork = lost.total > 0 ? lost.share * rebound.scaled_hertz_work : 0;
    return {
      captured: false,
      e,
      damping: lost,
      contact_time: hertzTime * depth ** -0.1 * (impulses.scaled_contact_time - slow),
      compressive: speed * Math.sqrt(depth) * impulses.scaled_compressive_impulse,
      hertz: speed * Math.sqrt(depth) * impulses.scaled_hertz_impulse,
      peak_net: speed * (1 + Math.sqrt(depth) * impulses.scaled_net_impulse),
      hertz_work: Math.min(Math.max(hertzWork, 0), Math.max(1 - e * e, 0)),
    };
  }

  // ---- capture velocity ---------------------------------------------------------------------
  function bisect(low, high, isLow) {
    let [a, b] = [Math.log(low), Math.log(high)];
    for (let i = 0; i < 200 && b - a > 4e-16 * Math.abs(a); i += 1) {
      const middle = 0.5 * (a + b);
      if (isLow(Math.exp(middle))) a = middle;
      else b = middle;
    }
    return Math.exp(0.5 * (a + b));
  }

  /** Normal speeds at which the tables hold for a contact: from, to; null if at none. */
  function range(c, scale) {
    const unit = scale.velocity || 1;
    const inside = (speed) => damping(c, speed).total <= largest_damping;
    const n = c.adhesion_rate_exponent;
    let calm = 1e-12 * unit;
    if (n > 1) {
      // D falls and rises again; here it is least.
      const fall = (n - 1) * c.adhesion_damping * c.reference_velocity ** n;
      calm = fall > 0 && c.hertz_damping > 0 ? (fall / (2 * c.hertz_damping)) ** (1 / n) : calm;
      if (fall > 0 && c.hertz_damping === 0) calm = 1e12 * unit;
    }
    if (!inside(calm)) return null;
    const floor = Math.min(1e-12 * unit, calm);
    const roof = Math.max(1e12 * unit, calm);
    const from = inside(floor) ? floor : bisect(floor, calm, (v) => !inside(v));
    const to = inside(roof) ? roof : bisect(calm, roof, inside);
    return { from, to };
  }

  /**
   * Normal speed at and below which the sphere stays. `kind`: "finite"; "infinite" where no speed
   * rebounds; "above" or "below" where the tables end before it, at `value`; "unknown".
   */
  function captureVelocity(c, scale = scales(c)) {
    const undamped = c.hertz_damping === 0 && c.adhesion_damping === 0;
    if (scale.velocity === 0 || undamped) return { kind: "finite", value: 0 };
    const [hertz, adhesion] = [c.hertz_damping, c.adhesion_damping].map((x) => x * scale.velocity);
    const constant = c.adhesion_rate_exponent === 0;
    if (hertz > hopeless_hertz_group || (constant && adhesion > hopeless_adhesion_group)) {
      return { kind: "infinite", value: Infinity };
    }
    const reach = range(c, scale);
    if (!reach) return { kind: "unknown", value: NaN };
    const stays = (speed) => speed / scale.velocity <= threshold(damping(c, speed));
    if (stays(reach.to)) return { kind: "above", value: reach.to };
    if (!stays(reach.from)) return { kind: "below", value: reach.from };
    return { kind: "finite", value: bisect(reach.from, reach.to, stays) };
  }

  // ---- oblique impact -----------------------------------------------------------------------
  /** Friction's impulse per mass against the slip, and whether the sphere ends rolling. */
  function friction(c, normal, slip, speed) {
    const available = normal.captured
      ? Infinity
      : { compressive: normal.compressive, hertz: normal.hertz, net: normal.peak_net }[c.basis];
    const rolling = normal.captured || slipPerImpulse * c.friction * available >= slip;
    const sliding = c.basis === "net" ? (1 + normal.e) * speed : available;
    return { rolling, size: rolling ? slip / slipPerImpulse : c.friction * sliding };
  }

  /** Where the energy went: shares of the energy, rotation included, before impact. */
  function shares(c, v, after, normal, radius) {
    const [before, now] = [radius * v.spin, radius * after.spin];
    const energy = v.n ** 2 + v.t ** 2 + inertia * before ** 2;
    const along = v.t ** 2 - after.t ** 2 + inertia * (before ** 2 - now ** 2);
    const lost = v.n ** 2 * (1 - normal.e ** 2);
    const material = normal.captured ? 0 : v.n ** 2 * normal.hertz_work;
    const parts = {
      translation: after.n ** 2 + after.t ** 2,
      rotation: inertia * now ** 2,
      friction: Math.max(along, 0),
      hertz_damping: material,
      adhesion_damping: normal.captured ? 0 : Math.max(lost - material, 0),
      capture: normal.captured ? lost : 0,
    };
    return Object.fromEntries(Object.entries(parts).map(([name, part]) => [name, part / energy]));
  }

  /**
   * Outcome of one impact.
   *
   * `c` has particle {youngs_modulus, poissons_ratio, density}, surface {youngs_modulus,
   * poissons_ratio}, diameter, work_of_adhesion, hertz_damping, adhesion_damping,
   * adhesion_rate_exponent, reference_velocity, friction, basis, speed, angle (degrees from the
   * surface) and spin.
   */
  function impact(c, scale = scales(c)) {
    const v = {
      n: c.speed * Math.sin((c.angle * Math.PI) / 180),
      t: c.speed * Math.sin(((90 - c.angle) * Math.PI) / 180),
      spin: c.spin,
    };
    const normal = normalImpact(c, scale, v.n);
    if (normal.outside) return { outside: true, damping: normal.damping, normal_speed: v.n };
    const slip = v.t - scale.radius * c.spin;
    const { rolling, size } = friction(c, normal, Math.abs(slip), v.n);
    const change = Math.sign(slip) * size;
    const turn = change / (inertia * scale.radius);
    const after = { n: normal.e * v.n, t: v.t - change, spin: c.spin + turn };
    const linear = c.speed ** 2 - after.n ** 2 - after.t ** 2;
    const rotational = -change * scale.radius * (c.spin + after.spin);
    return {
      outside: false,
      captured: normal.captured,
      rolling,
      normal_speed: v.n,
      tangential_speed: v.t,
      coefficient_of_restitution: normal.e,
      impulse_ratio: change / ((1 + normal.e) * v.n),
      contact_time: normal.contact_time,
      normal_velocity: after.n,
      tangential_velocity: after.t,
      spin: after.spin,
      translational_energy_loss: linear / c.speed ** 2,
      energy_loss: (linear + rotational) / c.speed ** 2,
      shares: shares(c, v, after, normal, scale.radius),
      damping: normal.damping,
    };
  }

  return { numbers, scales, impact, captureVelocity, range };
})();
