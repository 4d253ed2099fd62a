// Integration of the normal motion, Eq. (25), in its regular form, by Taylor series.
//
// With the compression x in units of a length scale, s = sqrt(x) (the contact radius), u = dx/dt
// and dt = s dtau the equation of motion is polynomial and smooth through s = 0:
//
//     ds/dtau = u/2,    du/dtau = b s^2 - s^4 - (b C_A s^2 + C_H s^4) u
//
// b is the strength of adhesion (1 in the adhesive scale, 0 without adhesion), C_A and C_H are the
// damping groups. C_A acts on the second leg, after the turning point u = 0; contact ends at s = 0.
// All names and scales are those of the Python kernel, which integrates the same way.
"use strict";
globalThis.Integrator = (() => {
  const ORDER = 20;
  // Of the path; the works, whose series converge more slowly, then keep about two digits less.
  const TOLERANCE = 1e-16;
  const MAX_STEPS = 1000;
  // Depth of the well, relative to the energy of approach, in which a rebound may stop short of
  // s = 0: at the threshold s falls towards zero for ever, and what is left decides.
  const NOTHING_LEFT = 1e-30;
  const INVERSE = Array.from({ length: ORDER + 1 }, (_, k) => 1 / (k + 1));

  // ---- series -------------------------------------------------------------------------------
  const series = () => new Float64Array(ORDER + 1);
  const [s, u, ring, hertz, ringLoss, hertzLoss, ringPower, hertzPower] = Array.from({ length: 8 }, series);

  /** Coefficient k of the product of two series. */
  function product(a, b, k) {
    let sum = 0;
    for (let j = 0; j <= k; j += 1) sum += a[j] * b[k - j];
    return sum;
  }

  /** Fill all series of a step from s[0] and u[0]: s^2, s^4, and each times u and times u^2. */
  function expand({ b, C_H }, C_A) {
    for (let k = 0; k <= ORDER; k += 1) {
      ring[k] = product(s, s, k);
      hertz[k] = product(ring, ring, k);
      ringLoss[k] = product(ring, u, k);
      hertzLoss[k] = product(hertz, u, k);
      ringPower[k] = product(ringLoss, u, k);
      hertzPower[k] = product(hertzLoss, u, k);
      if (k === ORDER) return;
      const force = b * (ring[k] - C_A * ringLoss[k]) - hertz[k] - C_H * hertzLoss[k];
      s[k + 1] = 0.5 * u[k] * INVERSE[k];
      u[k + 1] = force * INVERSE[k];
    }
  }

  function valueAt(c, h) {
    let value = c[ORDER];
    for (let k = ORDER - 1; k >= 0; k -= 1) value = value * h + c[k];
    return value;
  }

  /** Integral of a series from 0 to h. */
  function integralTo(c, h) {
    let value = c[ORDER] * INVERSE[ORDER];
    for (let k = ORDER - 1; k >= 0; k -= 1) value = value * h + c[k] * INVERSE[k];
    return value * h;
  }

  /** The step at which the last two terms of both s and u fall to the tolerance. */
  function stepSize() {
    const scale = TOLERANCE * Math.max(Math.abs(s[0]), Math.abs(u[0]));
    const reach = (k) => (scale / Math.max(Math.abs(s[k]), Math.abs(u[k]))) ** (1 / k);
    return Math.min(reach(ORDER), reach(ORDER - 1));
  }

  // ---- roots --------------------------------------------------------------------------------
  /** Zero of f between two ends of opposite sign: Chandrupatla's method, with a bracket throughout. */
  function zero(f, low, high) {
    let [a, b, fa, fb] = [low, high, f(low), f(high)];
    let [c, fc] = [a, fa];
    let part = 0.5;
    for (let i = 0; i < 100 && fb !== 0; i += 1) {
      const x = a + part * (b - a);
      const fx = f(x);
      if (Math.sign(fx) === Math.sign(fa)) [c, fc] = [a, fa];
      else [c, b, fc, fb] = [b, a, fb, fa];
      [a, fa] = [x, fx];
      const best = Math.abs(fa) < Math.abs(fb) ? a : b;
      const width = (2.3e-16 * Math.abs(best) + 1e-300) / Math.abs(b - a);
      if (width > 0.5 || fa === 0) return best;
      const [xi, phi] = [(a - b) / (c - b), (fa - fb) / (fc - fb)];
      const smooth = phi ** 2 < xi && (1 - phi) ** 2 < 1 - xi;
      const quadratic = () =>
        (fa / (fb - fa)) * (fc / (fb - fc)) +
        ((c - a) / (b - a)) * (fa / (fc - fa)) * (fb / (fc - fb));
      part = Math.min(Math.max(smooth ? quadratic() : 0.5, width), 1 - width);
    }
    return b;
  }

  // ---- an impact ----------------------------------------------------------------------------
  const wellEnergy = (radius, b) => radius ** 3 * (0.4 * radius ** 2 - (2 / 3) * b);

  /** The attraction over s^2: positive where the force pulls, negative where it pushes. */
  const pull = (radius, speed, { b, C_H }, C_A) => b * (1 - C_A * speed) - radius ** 2 * (1 + C_H * speed);

  /** Whether the time-reversed path (negative damping) can no longer come to rest. */
  function neverTurns(radius, speed, C_H, C_A) {
    if (1 + C_H * speed <= 0) return true;
    return C_A < 0 && -C_A * speed > 2 * radius ** 2 && radius > 2 + 4 / C_A ** 2;
  }

  /**
   * Integrate one impact from its start to the end of contact.
   *
   * `problem` has the start {s, u}, the groups {b, C_H} and C_A on each leg, `approach` and
   * `rebound`. Returns `outcome` ("rebound", "captured", "escaped" or "unsolved"), the speed `u` at
   * the end, and, in the scaled units, contact time, impulses and works per unit mass.
   *
   * In the adhesive scale the energy left near the surface is a small difference of large ones and
   * is taken from the works of damping instead of from the path.
   */
  function follow(problem) {
    const { b, C_H } = problem;
    const fromWorks = b === 1;
    const energy = 0.5 * problem.u ** 2 + wellEnergy(problem.s, b);
    const total = { time: 0, compressive: 0, hertz: 0, hertz_work: 0, adhesion_work: 0, lowest_u: problem.u };
    let C_A = problem.approach;
    let rebounding = false;
    let pulled = pull(problem.s, problem.u, problem, C_A) > 0;
    let mark = problem.u;
    const end = (outcome, speed) => ({ outcome, u: speed, ...total });
    [s[0], u[0]] = [problem.s, problem.u];

    for (let step = 0; step < MAX_STEPS; step += 1) {
      expand(problem, C_A);
      let h = stepSize();
      const ending = rebounding ? s : u;
      const event = valueAt(ending, h) <= 0;
      if (event) h = zero((x) => valueAt(ending, x), 0, h);
      let [endS, endU] = [valueAt(s, h), valueAt(u, h)];
      if (event && rebounding) endS = 0;
      else if (event) endU = 0;

      total.time += integralTo(s, h);
      total.hertz += integralTo(hertz, h);
      total.hertz_work += C_H * integralTo(hertzPower, h);
      total.adhesion_work += b * C_A * integralTo(ringPower, h);
      const left = energy - total.hertz_work - total.adhesion_work;
      if (!Number.isFinite(endU + left)) break;

      // u is extreme where the force changes its sign: between, the impulse of a push is its change.
      const pulls = pull(endS, endU, problem, C_A) > 0;
      if (pulls !== pulled) {
        const balance = zero((x) => pull(valueAt(s, x), valueAt(u, x), problem, C_A), 0, h);
        const extremum = valueAt(u, balance);
        if (pulls) {
          total.compressive += mark - extremum;
          total.lowest_u = Math.min(total.lowest_u, extremum);
        }
        [mark, pulled] = [extremum, pulls];
      }

      if (!rebounding && event) {
        [rebounding, C_A] = [true, problem.rebound];
      } else if (!rebounding) {
        if (neverTurns(endS, endU, C_H, C_A)) return end("escaped", endU);
      } else {
        const rest = fromWorks ? left : 0.5 * endU ** 2 + wellEnergy(endS, b);
        const nothing = b * endS ** 3 < NOTHING_LEFT * energy;
        if (!event && (endU >= 0 || rest < 0)) return end("captured", 0);
        if (event || (b > 0 && nothing)) {
          if (rest < 0) return end("captured", 0);
          if (fromWorks || !event) endU = -Math.sqrt(2 * rest);
          total.lowest_u = Math.min(total.lowest_u, endU);
          if (!pulled) total.compressive += mark - endU;
          return end("rebound", endU);
        }
        // Back onto the energy surface, where the path alone has lost it to rounding.
        if (fromWorks && endS ** 2 < 0.5) endU = -Math.sqrt(2 * (left - wellEnergy(endS, b)));
      }
      [s[0], u[0]] = [endS, endU];
    }
    return end("unsolved", NaN);
  }

  // Rest without compression is a degenerate point. On the branch that leaves it, s = r^2 and
  // u = r^3 y with y regular in r; at this r its neglected terms are below rounding.
  const BRANCH_START = 1e-3;

  /**
   * Speed just captured, in velocity scales, of given damping groups; infinite where none rebounds.
   *
   * Time reversal: a sphere that has just escaped, at rest, came with this speed.
   */
  function threshold(C_H, C_A) {
    const r = BRANCH_START;
    const y = Math.sqrt(4 / 3) + (4 / 9) * C_A * r ** 3 - (0.4 / Math.sqrt(4 / 3)) * r ** 4;
    const start = { s: r ** 2, u: r ** 3 * y };
    const found = follow({ ...start, b: 1, C_H: -C_H, approach: -C_A, rebound: 0 });
    return found.outcome === "escaped" ? Infinity : -found.u;
  }

  return { follow, threshold, zero, MAX_STEPS };
})();
