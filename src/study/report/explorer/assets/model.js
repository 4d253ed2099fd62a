// One impact: the normal motion by integration, all else in closed form. SI units; equation numbers
// are the article's.
"use strict";
globalThis.Explorer = (() => {
  const { follow, threshold, zero } = Integrator;
  const numbers = JSON.parse(document.getElementById("numbers").textContent);
  const { inertia, always_captured_hertz_group, always_captured_adhesion_group } = numbers.constants;
  const slipPerImpulse = 1 + 1 / inertia;

  // ---- normal motion ------------------------------------------------------------------------
  /**
   * Stiffness (20, 21), ring force (30) and the scales of a contact.
   *
   * `size` is the radius of the second sphere over the first's, infinite for a plane, and `share` the
   * reduced mass over the sphere's: 1 on a plane.
   */
  function scales(c) {
    const compliance = (body) => (1 - body.poissons_ratio ** 2) / (Math.PI * body.youngs_modulus);
    const radius = c.diameter / 2;
    const size = c.partner_diameter / c.diameter;
    const share = 1 / (1 + c.particle.density / c.surface.density / size ** 3);
    const stiffness = 4 / (3 * Math.PI * (compliance(c.particle) + compliance(c.surface)));
    const mass = (share * c.particle.density * Math.PI * c.diameter ** 3) / 6;
    const effective = radius / (1 + 1 / size);
    const ring = Math.cbrt((9 * stiffness * effective * c.work_of_adhesion ** 2) / (2 * Math.PI));
    const spring = Math.sqrt(effective) * stiffness;
    const equilibrium = (2 * Math.PI * ring) / stiffness;
    const velocity = Math.sqrt((spring * equilibrium ** 2.5) / mass);
    return { radius, size, share, stiffness, mass, ring_force: ring, spring, equilibrium, velocity };
  }

  /** Coefficient c_A that acts at a normal speed. */
  function adhesionDamping(c, speed) {
    if (!c.adhesion_rate_exponent) return c.adhesion_damping;
    return c.adhesion_damping * (c.reference_velocity / speed) ** c.adhesion_rate_exponent;
  }

  /** Outcome of a normal impact, impulses per mass; `unsolved` where it takes too many steps. */
  function normalImpact(c, scale, speed) {
    const c_A = adhesionDamping(c, speed);
    const stays = { captured: true, e: 0, contact_time: Infinity };
    const groups = [c.hertz_damping * scale.velocity, c_A * scale.velocity];
    if (groups[0] > always_captured_hertz_group || groups[1] > always_captured_adhesion_group) return stays;
    // Units of the adhesive scale below its velocity, of the impact's own speed above.
    const adhesive = speed < scale.velocity;
    const unit = adhesive ? scale.velocity : speed;
    const length = adhesive ? scale.equilibrium : ((scale.mass * speed ** 2) / scale.spring) ** 0.4;
    const start = { s: 0, u: speed / unit, b: scale.equilibrium / length };
    const found = follow({ ...start, C_H: c.hertz_damping * unit, approach: 0, rebound: c_A * unit });
    if (found.outcome === "unsolved") return { unsolved: true };
    if (found.outcome === "captured") return stays;
    const e = Math.min(-found.u / start.u, 1);
    return {
      captured: false,
      e,
      contact_time: (found.time * length) / unit,
      compressive: found.compressive * unit,
      hertz: found.hertz * unit,
      peak_net: speed - found.lowest_u * unit,
      hertz_work: Math.min(found.hertz_work / (0.5 * start.u ** 2), 1 - e * e),
    };
  }

  // ---- capture velocity ---------------------------------------------------------------------
  // Beyond these, in logarithms of speeds in velocity scales and of damping groups, is nothing new.
  const [LARGEST_LOG_SPEED, LARGEST_LOG_GROUP] = [50, 7];

  /** Normal speed at and below which the sphere stays: infinite where no speed rebounds. */
  function captureVelocity(c, scale = scales(c)) {
    if (scale.velocity === 0) return 0;
    const [hertz, adhesion] = [c.hertz_damping, c.adhesion_damping].map((x) => x * scale.velocity);
    if (hertz === 0 && adhesion === 0) return 0;
    const n = adhesion > 0 ? c.adhesion_rate_exponent : 0;
    const limit = (group) =>
      hertz > always_captured_hertz_group || group > always_captured_adhesion_group ? Infinity : threshold(hertz, group);
    if (n === 0) return scale.velocity * limit(adhesion);
    if (hertz > 0 && limit(0) === Infinity) return Infinity;
    // w = limit(C_A (v_N/(w V))^n): the right side falls with w, so one w does, between any w and it.
    const logReference = Math.log(c.reference_velocity / scale.velocity);
    const logLimit = (logW) => {
      const logGroup = Math.log(adhesion) + n * (logReference - logW);
      return Math.log(limit(Math.exp(Math.min(logGroup, LARGEST_LOG_GROUP))));
    };
    const excess = (logW) => Math.max(logW - logLimit(logW), -LARGEST_LOG_SPEED);
    if (excess(LARGEST_LOG_SPEED) <= 0) return Infinity;
    const other = Math.min(Math.max(logLimit(logReference), -LARGEST_LOG_SPEED), LARGEST_LOG_SPEED);
    return scale.velocity * Math.exp(zero(excess, logReference, other));
  }

  // ---- oblique impact -----------------------------------------------------------------------
  /** Friction's impulse per mass against the slip, and whether the sphere ends rolling. */
  function friction(c, normal, slip, speed) {
    const pressed = c.friction > 0 ? Infinity : 0;
    const available = normal.captured
      ? pressed
      : { compressive: normal.compressive, hertz: normal.hertz, net: normal.peak_net }[c.basis];
    const rolling = slipPerImpulse * c.friction * available >= slip;
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
   * `c` has particle and surface {youngs_modulus, poissons_ratio, density}, diameter,
   * partner_diameter (of a second sphere, of the surface's material; infinite for a plane),
   * work_of_adhesion, hertz_damping, adhesion_damping, adhesion_rate_exponent, reference_velocity,
   * friction, basis, speed, angle (degrees from the surface), spin and partner_spin.
   *
   * Two spheres move, relative to each other, as one of the reduced mass with the spin of both.
   */
  function impact(c, scale = scales(c)) {
    const v = {
      n: c.speed * Math.sin((c.angle * Math.PI) / 180),
      t: c.speed * Math.sin(((90 - c.angle) * Math.PI) / 180),
      spin: c.partner_spin === 0 ? c.spin : c.spin + scale.size * c.partner_spin,
    };
    const normal = normalImpact(c, scale, v.n);
    if (normal.unsolved) return { unsolved: true };
    const slip = v.t - scale.radius * v.spin;
    const { rolling, size } = friction(c, normal, Math.abs(slip), v.n);
    const change = Math.sign(slip) * size;
    const turn = change / (inertia * scale.radius);
    const after = { n: normal.e * v.n, t: v.t - change, spin: v.spin + turn };
    const linear = c.speed ** 2 - after.n ** 2 - after.t ** 2;
    const rotational = -change * scale.radius * (v.spin + after.spin);
    return {
      unsolved: false,
      captured: normal.captured,
      rolling,
      normal_speed: v.n,
      tangential_speed: v.t,
      coefficient_of_restitution: normal.e,
      impulse_ratio: change / ((1 + normal.e) * v.n),
      contact_time: normal.contact_time,
      normal_velocity: after.n,
      tangential_velocity: after.t,
      spin: c.spin + scale.share * turn,
      partner_spin: c.partner_spin + ((1 - scale.share) / scale.size) * turn,
      translational_energy_loss: linear / c.speed ** 2,
      energy_loss: (linear + rotational) / c.speed ** 2,
      shares: shares(c, v, after, normal, scale.radius),
    };
  }

  return { numbers, scales, impact, captureVelocity };
})();
