// The form and the numbers of the explorer: from what is typed to what is shown.
"use strict";
globalThis.Page = (() => {
  const { numbers, impact, captureVelocity, scales } = Explorer;
  const { digits, speedText, timeText, spinText, captureText } = Words;
  const byId = (id) => document.getElementById(id);
  const texts = () => Object.fromEntries(Fields.list.map(({ key }) => [key, byId(key).value]));
  const OWN = "own numbers";
  const CHOICES = {
    particle: ["particle_E", "particle_nu", "particle_rho"],
    surface: ["surface_E", "surface_nu", "surface_rho"],
  };
  const CONTACT = {
    d: "diameter", w: "work_of_adhesion", cH: "hertz_damping", cA: "adhesion_damping",
    n: "adhesion_rate_exponent", vN: "reference_velocity", f: "friction",
  };
  const MATERIAL = { E: "youngs_modulus", nu: "poissons_ratio", rho: "density" };
  const START = { case: "steel-silicon, n = 1", v: "1.66", angle: "45", spin: "0", spin2: "0", vN: "1.66" };

  // ---- choices ------------------------------------------------------------------------------
  function fillChoices() {
    const option = (value, text = value) => new Option(text, value);
    for (const role of Object.keys(CHOICES)) {
      byId(role).append(...numbers.materials.map((m) => option(m.material, m.material.replaceAll("-", " "))));
      byId(role).append(option(OWN));
    }
    for (const [origin, title] of [["calibrated", "Calibrated cases"], ["declared", "Declared pairs"]]) {
      const group = document.createElement("optgroup");
      group.label = title;
      const own = numbers.contacts.filter((contact) => contact.origin === origin);
      group.append(...own.map(({ contact }) => option(contact)));
      byId("contact").append(group);
    }
    byId("contact").append(option(OWN));
  }

  function setMaterial(role, name) {
    const material = numbers.materials.find((m) => m.material === name);
    if (!material) return;
    for (const key of CHOICES[role]) {
      byId(key).value = Fields.shown(key, material[MATERIAL[key.split("_")[1]]]);
    }
  }

  function setContact(name) {
    const contact = numbers.contacts.find((c) => c.contact === name);
    if (!contact) return;
    for (const role of Object.keys(CHOICES)) setMaterial(role, contact[role]);
    byId("D").value = Fields.PLANE;
    for (const [key, property] of Object.entries(CONTACT)) {
      if (contact[property] !== null) byId(key).value = Fields.shown(key, contact[property]);
    }
  }

  /** Choices follow the numbers: the name of what is declared, or "own numbers". */
  function nameChoices(now) {
    const same = (key, si) => Fields.parsed(now[key]) === Number(Fields.shown(key, si));
    for (const [role, keys] of Object.entries(CHOICES)) {
      const match = (m) => keys.every((key) => same(key, m[MATERIAL[key.split("_")[1]]]));
      const chosen = numbers.materials.find((m) => m.material === byId(role).value);
      const found = chosen && match(chosen) ? chosen : numbers.materials.find(match);
      byId(role).value = found ? found.material : OWN;
    }
    const equal = (c) =>
      Fields.parsed(now.D) === Infinity && c.particle === byId("particle").value && c.surface === byId("surface").value &&
      Object.entries(CONTACT).every(([key, name]) => c[name] === null || same(key, c[name]));
    byId("contact").value = numbers.contacts.find(equal)?.contact ?? OWN;
  }

  // ---- outcome ------------------------------------------------------------------------------
  const say = (key, text) => { byId(`out_${key}`).textContent = text; };

  function clear() {
    for (const cell of document.querySelectorAll("[id^=out_]")) cell.textContent = "–";
    for (const svg of document.querySelectorAll(".x-plots svg")) Plots.clear(svg);
    byId("budget").replaceChildren();
    byId("budget").setAttribute("aria-label", "Nothing to show");
    byId("budget_key").replaceChildren();
    byId("verdict").textContent = "";
    byId("verdict").dataset.outcome = "none";
  }

  function complain(message, keys = []) {
    byId("problem").hidden = !message;
    if (byId("problem").textContent !== message) byId("problem").textContent = message;
    for (const field of Fields.list) {
      const wrong = keys.includes(field.key);
      const input = byId(field.key);
      if (wrong) {
        input.setAttribute("aria-invalid", "true");
        input.setAttribute("aria-describedby", "problem");
        input.closest("details")?.setAttribute("open", "");
      } else {
        input.removeAttribute("aria-invalid");
        input.removeAttribute("aria-describedby");
      }
    }
    if (message) clear();
  }

  function showNumbers(c, scale, found, limit) {
    const speed = Math.hypot(found.normal_velocity, found.tangential_velocity);
    const lift = (Math.atan2(found.normal_velocity, found.tangential_velocity) * 180) / Math.PI;
    say("e", digits(found.coefficient_of_restitution));
    say("mu", digits(found.impulse_ratio));
    say("vc", captureText(limit));
    say("vn", speedText(found.normal_speed));
    say("V", speedText(speed) + (found.captured && speed > 0 ? ", rolling" : ""));
    say("rebound_angle", found.captured ? "stays" : `${digits(lift)}°`);
    say("Omega", spinText(found.spin));
    byId("out_Omega2").closest(".x-result").hidden = !Number.isFinite(scale.size);
    say("Omega2", spinText(found.partner_spin));
    say("time", timeText(found.contact_time));
    say("TL", digits(found.translational_energy_loss));
    say("total", digits(found.energy_loss));
    const motion = found.rolling ? "rolling" : "sliding to the end";
    const e = digits(found.coefficient_of_restitution, 3);
    byId("verdict").dataset.outcome = found.captured ? "captured" : "rebound";
    const text = found.captured
      ? `Captured: ${Number.isFinite(scale.size) ? "the spheres stay together" : "the sphere stays on the surface"}.`
      : `Rebounds, ${motion}: e = ${e}, impulse ratio ${digits(found.impulse_ratio, 3)}.`;
    if (byId("verdict").textContent !== text) byId("verdict").textContent = text;
  }

  const BUDGET = {
    translation: "motion afterwards", rotation: "spin afterwards", friction: "friction",
    hertz_damping: "Hertz damping", adhesion_damping: "adhesion damping", capture: "lost in capture",
  };

  function showBudget({ shares }) {
    const present = Object.entries(BUDGET).filter(([name]) => shares[name] >= 5e-4);
    const percent = (name) => `${(100 * shares[name]).toFixed(1)} %`;
    const part = (tag, name, text) => {
      const made = document.createElement(tag);
      made.className = `part ${name}`;
      made.textContent = text;
      return made;
    };
    byId("budget").replaceChildren(...present.map(([name]) => {
      const made = part("span", name, "");
      made.style.flexGrow = shares[name];
      return made;
    }));
    const keys = present.map(([name, words]) => part("li", name, `${words} ${percent(name)}`));
    byId("budget_key").replaceChildren(...keys);
    const spoken = present.map(([name, words]) => `${words} ${percent(name)}`).join(", ");
    byId("budget").setAttribute("aria-label", `Shares of the energy before impact: ${spoken}`);
  }

  // ---- running ------------------------------------------------------------------------------
  function update() {
    const now = texts();
    const basis = byId("basis").value;
    for (const field of Fields.list) {
      const slider = byId(`${field.key}_slider`);
      const value = Fields.parsed(now[field.key]);
      if (slider && Number.isFinite(value)) {
        if (slider !== document.activeElement) slider.value = Fields.position(field, value);
        slider.setAttribute("aria-valuetext", `${now[field.key]} ${field.unit}`.trim());
      }
    }
    nameChoices(now);
    const wrong = Fields.problems(now);
    if (wrong.length) return complain(wrong.map((w) => w.message).join(" "), wrong.map((w) => w.key));
    const fragment = Fields.toFragment(now, basis);
    byId("permalink").href = `#${fragment}`;
    history.replaceState(null, "", `#${fragment}`);
    const c = Fields.toArguments(now, basis);
    const scale = scales(c);
    const found = impact(c, scale);
    const held = [scale.stiffness, scale.mass, scale.velocity, found.energy_loss ?? 0, found.spin ?? 0];
    if (!held.every(Number.isFinite) || scale.mass === 0) {
      return complain("These numbers together are beyond what a computer’s arithmetic holds.");
    }
    if (found.unsolved) {
      return complain(
        `Damping or adhesion is too strong at this speed: following the motion takes more than ${Integrator.MAX_STEPS} steps.`,
      );
    }
    complain("");
    const limit = captureVelocity(c, scale);
    showNumbers(c, scale, found, limit);
    showBudget(found);
    Views.restitution(byId("plot_e"), c, scale, found, limit);
    Views.angles({ ratio: byId("plot_mu"), loss: byId("plot_loss") }, c, scale, found, limit);
    return undefined;
  }

  let waiting = 0;
  function soon() {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(update);
  }

  function begin() {
    for (const key of ["v", "angle", "spin", "spin2", "vN"]) byId(key).value = START[key];
    byId("basis").value = Fields.BASES[0];
    setContact(numbers.contacts.some((c) => c.contact === START.case) ? START.case : numbers.contacts[0].contact);
  }

  function restore() {
    const { texts: given, basis, contact, unknown } = Fields.fromFragment(location.hash);
    if (contact !== undefined && !numbers.contacts.some((c) => c.contact === contact)) {
      unknown.push(`contact=${contact}`);
    }
    const names = unknown.map((name) => `“${name}”`).join(", ");
    byId("link_problem").hidden = unknown.length === 0;
    byId("link_problem").textContent = `The link names what this page does not have: ${names}. It is left out.`;
    if (contact !== undefined) setContact(contact);
    for (const [key, text] of Object.entries(given)) byId(key).value = text;
    if (basis) byId("basis").value = basis;
    update();
  }

  /** After typing, and after a change that no typing made. */
  function listen(id, act) {
    for (const event of ["input", "change"]) {
      byId(id)?.addEventListener(event, ({ target }) => {
        act(target.value);
        soon();
      });
    }
  }

  function wire() {
    for (const field of Fields.list) {
      listen(field.key, () => {});
      listen(`${field.key}_slider`, (place) => {
        byId(field.key).value = String(Fields.atPosition(field, Number(place)));
      });
    }
    listen("basis", () => {});
    for (const role of Object.keys(CHOICES)) listen(role, (name) => setMaterial(role, name));
    listen("contact", setContact);
    byId("reset").addEventListener("click", () => { begin(); update(); });
    byId("controls").addEventListener("submit", (event) => event.preventDefault());
    addEventListener("hashchange", restore);
  }

  fillChoices();
  wire();
  begin();
  restore();
  return { update };
})();
