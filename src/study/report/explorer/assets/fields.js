// The fields of the form: what they are called, in which unit they are written, what they allow.
"use strict";
globalThis.Fields = (() => {
  const positive = { test: (x) => x > 0, text: "a number greater than 0" };
  const notNegative = { test: (x) => x >= 0, text: "0 or a positive number" };
  const ratio = { test: (x) => x > -1 && x <= 0.5, text: "a number above −1 and up to 0.5" };
  const angle = { test: (x) => x > 0 && x <= 90, text: "a number above 0 and up to 90 degrees" };
  const speed = { test: (x) => x > 0 && x < 299792458, text: "greater than 0 and below that of light" };
  const either = { test: (x) => x > 0, text: "greater than 0, or ∞ for a plane", infinite: true };
  const diameter = { test: (x) => x > 0 && x <= 1e4, text: "greater than 0 and up to 10000 µm" };
  const finite = { test: () => true, text: "a finite number" };

  // factor: from the unit shown to SI. low, high: ends of the slider, in the unit shown.
  // curve: how the slider runs. "cubic" reaches zero, "odd" both signs.
  const list = [
    { key: "particle_E", name: "Young’s modulus of the particle", factor: 1e9, allowed: positive },
    { key: "particle_nu", name: "Poisson’s ratio of the particle", factor: 1, allowed: ratio },
    { key: "particle_rho", name: "Density of the particle", factor: 1, allowed: positive },
    { key: "surface_E", name: "Young’s modulus of the surface", factor: 1e9, allowed: positive },
    { key: "surface_nu", name: "Poisson’s ratio of the surface", factor: 1, allowed: ratio },
    { key: "surface_rho", name: "Density of the surface", factor: 1, allowed: positive },
    { key: "D", name: "Diameter of the second sphere", unit: "µm", factor: 1e-6, allowed: either },
    { key: "d", name: "Diameter", unit: "µm", factor: 1e-6, curve: "log", low: 0.1, high: 1000, allowed: diameter },
    { key: "w", name: "Work of adhesion", unit: "J/m²", factor: 1, curve: "cubic", low: 0, high: 10, allowed: notNegative },
    { key: "cH", name: "Hertz damping", unit: "s/m", factor: 1, curve: "cubic", low: 0, high: 2, allowed: notNegative },
    { key: "cA", name: "Adhesion damping", unit: "s/m", factor: 1, curve: "cubic", low: 0, high: 5, allowed: notNegative },
    { key: "n", name: "Rate exponent", unit: "", factor: 1, curve: "linear", low: 0, high: 2, allowed: notNegative },
    { key: "vN", name: "Reference velocity", unit: "m/s", factor: 1, curve: "log", low: 0.01, high: 100, allowed: positive },
    { key: "f", name: "Friction coefficient", unit: "", factor: 1, curve: "linear", low: 0, high: 1, allowed: notNegative },
    { key: "v", name: "Speed", unit: "m/s", factor: 1, curve: "log", low: 0.01, high: 50, allowed: speed },
    { key: "angle", name: "Angle from the surface", unit: "degrees", factor: 1, curve: "linear", low: 0.5, high: 90, allowed: angle },
    { key: "spin", name: "Initial spin", unit: "rad/s", factor: 1, curve: "odd", low: -1e6, high: 1e6, allowed: finite },
    { key: "spin2", name: "Spin of the second sphere", factor: 1, allowed: finite },
  ];
  const byKey = Object.fromEntries(list.map((field) => [field.key, field]));

  const PLANE = "∞";
  const BASES = ["compressive", "hertz", "net"];

  /** Slider positions run from 0 to 1. */
  function position({ curve, low, high }, value) {
    const clipped = Math.min(Math.max(value, low), high);
    if (curve === "log") return Math.log(clipped / low) / Math.log(high / low);
    if (curve === "cubic") return Math.cbrt(clipped / high);
    if (curve === "odd") return 0.5 + 0.5 * Math.cbrt(clipped / high);
    return (clipped - low) / (high - low);
  }

  function atPosition({ curve, low, high }, place) {
    const exact = {
      log: low * (high / low) ** place,
      cubic: high * place ** 3,
      odd: high * (2 * place - 1) ** 3,
      linear: low + (high - low) * place,
    }[curve];
    return Number(exact.toPrecision(3));
  }

  /** The number that a text means; NaN if none. A comma may replace the point. */
  function parsed(text) {
    const plain = text.trim().replace("−", "-").replace(",", ".");
    if (plain === PLANE || plain === "inf") return Infinity;
    return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
  }

  /** Every text that is no admissible number, as {key, message}, in the order of the form. */
  function problems(texts) {
    const isPlane = parsed(texts.D) === Infinity;
    return list.flatMap(({ key, name, allowed }) => {
      const value = parsed(texts[key]);
      if (key === "spin2" && isPlane && value !== 0) return [{ key, message: `${name}: a plane does not spin.` }];
      if ((Number.isFinite(value) || allowed.infinite) && allowed.test(value)) return [];
      const given = texts[key].trim() === "" ? "is empty" : `“${texts[key].trim()}”`;
      return [{ key, message: `${name} ${given}: it must be ${allowed.text}.` }];
    });
  }

  /** What the model takes, in SI, from the texts of the form. */
  function toArguments(texts, basis) {
    const si = (key) => parsed(texts[key]) * byKey[key].factor;
    return {
      particle: {
        youngs_modulus: si("particle_E"),
        poissons_ratio: si("particle_nu"),
        density: si("particle_rho"),
      },
      surface: {
        youngs_modulus: si("surface_E"),
        poissons_ratio: si("surface_nu"),
        density: si("surface_rho"),
      },
      diameter: si("d"),
      partner_diameter: si("D"),
      work_of_adhesion: si("w"),
      hertz_damping: si("cH"),
      adhesion_damping: si("cA"),
      adhesion_rate_exponent: si("n"),
      reference_velocity: si("vN"),
      friction: si("f"),
      speed: si("v"),
      angle: si("angle"),
      spin: si("spin"),
      partner_spin: si("spin2"),
      basis,
    };
  }

  /** A number of SI as text in a field's unit. */
  function shown(key, value) {
    return String(Number((value / byKey[key].factor).toPrecision(6)));
  }

  /**
   * The texts of a state as a fragment of an address, and back with the keys that are not known.
   * Where it names a contact, the texts are of what differs from that contact.
   */
  function toFragment(texts, basis) {
    return new URLSearchParams({ ...texts, basis }).toString();
  }

  function fromFragment(fragment) {
    const given = Object.fromEntries(new URLSearchParams(fragment.replace(/^#/, "")));
    const known = Object.entries(given).filter(([key]) => key in byKey);
    const named = new Set([...Object.keys(byKey), "basis", "contact"]);
    const unknown = Object.keys(given).filter((key) => !named.has(key));
    if (given.basis !== undefined && !BASES.includes(given.basis)) unknown.push(`basis=${given.basis}`);
    const basis = BASES.includes(given.basis) ? given.basis : null;
    return { texts: Object.fromEntries(known), basis, contact: given.contact, unknown };
  }

  return {
    list, byKey, BASES, PLANE, position, atPosition, parsed, problems, shown, toFragment, fromFragment, toArguments,
  };
})();
