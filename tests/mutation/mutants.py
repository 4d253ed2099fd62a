"""Wrong forms that the tests must notice, each put in place of the right one."""

from __future__ import annotations

from dataclasses import dataclass

MODEL, LAB, STUDIES = (f"src/microimpact/{room}" for room in ("model", "lab", "studies"))


@dataclass(frozen=True, slots=True)
class Mutant:
    """One wrong form.

    Attributes
    ----------
    name
        What is wrong.
    path
        The file, from the project's root.
    right, wrong
        Text there, which occurs once, and what replaces it.
    tests
        Names of the test modules, without ``test_``, of which one must fail.
    table
        A table of results that must differ from its reference instead, where no test module is
        named.
    """

    name: str
    path: str
    right: str
    wrong: str
    tests: tuple[str, ...] = ()
    table: str = ""

    def apply(self, text: str) -> str:
        """Return a file's text with the wrong form in it."""
        found = text.count(self.right)
        if found != 1:
            raise ValueError(f"{self.name}: {self.right!r} occurs {found} times in {self.path}")
        return text.replace(self.right, self.wrong)


# Misprints of the article, equation by equation.
MISPRINTS = (
    Mutant(
        "Eq. 8: k^2 where r belongs",
        f"{MODEL}/rigid_body/algebra.py",
        "spin = omega + change / (INERTIA * radius)",
        "spin = omega + change / (INERTIA * radius**2)",
        ("model/rigid_body/test_rigid_body",),
    ),
    Mutant(
        "Eq. 14: translational loss for the total",
        f"{MODEL}/rigid_body/algebra.py",
        "impulse * eta - 3.5 * np.square(impulse)",
        "impulse * eta - np.square(impulse)",
        ("model/rigid_body/test_rigid_body",),
    ),
    Mutant(
        "Eq. 18: the first of the two works of adhesion",
        f"{MODEL}/rigid_body/algebra.py",
        "rho * (2.0 - rho)",
        "rho * (1.0 - rho)",
        ("model/rigid_body/test_rigid_body",),
    ),
    Mutant(
        "Eq. 20: square of k_1 + k_2",
        f"{MODEL}/contact.py",
        "return 4.0 / (3.0 * np.pi * (k_1 + k_2))",
        "return 4.0 / (3.0 * np.pi * (k_1 + k_2) ** 2)",
        ("model/test_contact",),
    ),
    Mutant(
        "Eqs. 23-25: exponent 5/2 for 2/5",
        f"{MODEL}/contact.py",
        "return np.power(self.mass / group, 0.4)",
        "return np.power(self.mass / group, 2.5)",
        ("model/test_contact",),
    ),
    Mutant(
        "Eq. 27: friction driven by attraction",
        f"{MODEL}/dynamics/impact.py",
        'impulse = normal.hertz_impulse if basis == "hertz" else normal.compressive_impulse',
        "impulse = normal.peak_net_impulse",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "Eq. 29: moment +R F_t",
        f"{MODEL}/passes.py",
        "spin + change / (INERTIA * radius)",
        "spin - change / (INERTIA * radius)",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "Eq. 33: no cut at the capture velocity",
        f"{MODEL}/empirical/equations.py",
        "    excess = np.maximum(speed - capture, 0.0)",
        "    excess = np.abs(speed - capture)",
        ("model/empirical/test_restitution",),
    ),
    Mutant(
        "Eq. 35: minus in the denominator",
        f"{MODEL}/rigid_body/roughness.py",
        "before = np.sin(angle + 2.0 * slope) if printed else np.sin(angle)",
        "before = np.sin(angle + 2.0 * slope)",
        ("model/rigid_body/test_roughness",),
    ),
    Mutant(
        "Eq. 38: without mu^2",
        f"{MODEL}/rigid_body/roughness.py",
        "return mu - slope * (1.0 if printed else 1.0 + np.square(mu))",
        "return mu - slope",
        ("model/rigid_body/test_roughness",),
    ),
    Mutant(
        "Eq. 39: without e phi^2",
        f"{MODEL}/rigid_body/roughness.py",
        "bend = 1.0 if printed else 1.0 + e",
        "bend = 1.0",
        ("model/rigid_body/test_roughness",),
    ),
    Mutant(
        "below Eq. 40: 9/7 for e + 5/7",
        f"{MODEL}/rigid_body/roughness.py",
        "bend = e + 1.0 - ROLLING_SHARE",
        "bend = 1.0 + ROLLING_SHARE",
        ("model/rigid_body/test_roughness",),
    ),
    Mutant(
        "Eq. 41: sign of the spin",
        f"{MODEL}/rigid_body/roughness.py",
        "return -slope * (1.0 - share + np.square(spun)) + spun",
        "return -slope * (1.0 - share + np.square(spun)) - spun",
        ("model/rigid_body/test_roughness",),
    ),
    Mutant(
        "Section 2.1: a constant velocity added for the fall",
        f"{LAB}/pdpa/pairing.py",
        "return np.asarray(np.sign(velocity) * _surface_speed(velocity, height))",
        "return np.asarray(velocity + np.sign(velocity) * _surface_speed(0.0, height))",
        ("lab/pdpa/test_pairing",),
    ),
    Mutant(
        "Section 2.1: the rebound corrected downwards",
        f"{LAB}/pdpa/pairing.py",
        "return np.sqrt(np.square(velocity) + 2.0 * gravity * np.asarray(height))",
        "return np.sqrt(np.square(velocity) - 2.0 * gravity * np.asarray(height))",
        ("lab/pdpa/test_pairing",),
    ),
)

# Factors and terms dropped, signs turned, ends mistaken.
SLIPS = (
    Mutant(
        "Eq. 12: 2/5 for 2/7",
        f"{MODEL}/rigid_body/algebra.py",
        "return 2.0 * slip / (7.0 * (1.0 + e) * v_n)",
        "return 2.0 * slip / (5.0 * (1.0 + e) * v_n)",
        ("model/rigid_body/test_rigid_body",),
    ),
    Mutant(
        "moment of inertia of a shell",
        f"{MODEL}/rigid_body/algebra.py",
        "INERTIA = 0.4\n",
        "INERTIA = 2.0 / 3.0\n",
        ("model/rigid_body/test_rigid_body",),
    ),
    Mutant(
        "Eq. 21: Poisson's ratio not squared",
        f"{MODEL}/contact.py",
        "(1.0 - np.square(m.poissons_ratio))",
        "(1.0 - m.poissons_ratio)",
        ("model/test_contact",),
    ),
    Mutant(
        "Eq. 22: radii in series",
        f"{MODEL}/contact.py",
        "return 1.0 / (1.0 / self.radius + 1.0 / np.asarray(self.surface_radius))[()]",
        "return 1.0 / (1.0 / self.radius + 2.0 / np.asarray(self.surface_radius))[()]",
        ("model/test_contact",),
    ),
    Mutant(
        "Eq. 30: work of adhesion not squared",
        f"{MODEL}/contact.py",
        "np.square(work_of_adhesion) / (2.0 * np.pi)",
        "work_of_adhesion / (2.0 * np.pi)",
        ("model/test_contact",),
    ),
    Mutant(
        "Eq. 31: 5/9 to the power 1",
        f"{MODEL}/contact.py",
        "1.0 - 2.5 * (5.0 / 9.0) ** 1.5 / 6.0",
        "1.0 - 2.5 * (5.0 / 9.0) / 6.0",
        ("model/test_contact",),
    ),
    Mutant(
        "ring force over half the circumference",
        f"{MODEL}/contact.py",
        "return 2.0 * np.pi * self.ring_force / self.stiffness",
        "return np.pi * self.ring_force / self.stiffness",
        ("model/test_contact", "model/dynamics/test_normal"),
    ),
    Mutant(
        "mass from the radius cubed",
        f"{MODEL}/contact.py",
        "np.power(self.diameter, 3) / 6.0",
        "np.power(self.radius, 3) / 6.0",
        ("model/test_contact",),
    ),
    Mutant(
        "damping rate the wrong way round",
        f"{MODEL}/contact.py",
        "ratio = self.reference_velocity / np.asarray(speed)",
        "ratio = np.asarray(speed) / self.reference_velocity",
        ("model/test_contact", "model/dynamics/test_normal"),
    ),
    Mutant(
        "adhesion damped on approach, too",
        f"{MODEL}/dynamics/normal.py",
        "    if contact.damped_attachment:\n",
        "    if True:\n",
        ("model/dynamics/test_normal",),
    ),
    Mutant(
        "no Hertz damping in the compiled integration",
        f"{MODEL}/dynamics/kernel.py",
        "m[k + 1, lane] = damping_a[lane] * next_pull + damping_h[lane] * odd",
        "m[k + 1, lane] = damping_a[lane] * next_pull",
        ("model/dynamics/test_normal",),
    ),
    Mutant(
        "ds/dtau = u for u/2",
        f"{MODEL}/dynamics/kernel.py",
        "s[row + 1, lane] = 0.5 * inverse * u[row, lane]",
        "s[row + 1, lane] = inverse * u[row, lane]",
        ("model/dynamics/test_normal",),
    ),
    Mutant(
        "well half as deep",
        f"{MODEL}/dynamics/kernel.py",
        "return s * s * s * (0.4 * s * s - 2.0 / 3.0 * beta)",
        "return s * s * s * (0.4 * s * s - 1.0 / 3.0 * beta)",
        ("model/dynamics/test_normal",),
    ),
    Mutant(
        "time reversal damps adhesion with the wrong sign",
        f"{MODEL}/dynamics/capture.py",
        "problems[:, kernel.DAMPING_1] = -adhesion_group",
        "problems[:, kernel.DAMPING_1] = adhesion_group",
        ("model/dynamics/test_capture",),
    ),
    Mutant(
        "tables: the rate of adhesion damping left out of the velocity scale",
        f"{MODEL}/law/families.py",
        "rate = np.power(rho, 1.0 - self.exponent) * np.power(w, -self.exponent)",
        "rate = rho * np.power(w, -self.exponent)",
        ("model/law/test_table",),
    ),
    Mutant(
        "tables: places within a piece mirrored",
        f"{MODEL}/passes.py",
        "(row, 2.0 * (along - part) - 1.0, ",
        "(row, 1.0 - 2.0 * (along - part), ",
        ("model/law/test_table",),
    ),
    Mutant(
        "compressive impulse for that of the Hertz term",
        f"{MODEL}/dynamics/kernel.py",
        "found[6, i] = results[i, HERTZ_IMPULSE] * impulse",
        "found[6, i] = results[i, COMPRESSIVE_IMPULSE] * impulse",
        ("model/dynamics/test_trajectory",),
    ),
    Mutant(
        "slip lost 1 + 2/5 times for 7/2",
        f"{MODEL}/rigid_body/algebra.py",
        "SLIP_PER_IMPULSE = 1.0 + 1.0 / INERTIA",
        "SLIP_PER_IMPULSE = 1.0 + INERTIA",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "a captured sphere rolls without friction",
        f"{MODEL}/dynamics/impact.py",
        "stays = normal.captured & (np.asarray(contact.friction) > 0.0)",
        "stays = np.asarray(normal.captured)",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "a heavily damped sphere comes from rest without delay",
        f"{MODEL}/dynamics/normal.py",
        "(at_top * lag_top - at_rest * lag_rest)[:, 0]",
        "0.0",
        ("model/dynamics/test_normal",),
    ),
    Mutant(
        "a JKR contact breaks where the force is least",
        f"{MODEL}/dynamics/laws.py",
        "return np.minimum(np.cbrt(self.b * self.flattening), self.top)",
        "return np.minimum(np.cbrt(3.0 * self.b * self.flattening), self.top)",
        ("model/dynamics/test_laws",),
    ),
    Mutant(
        "a plastic contact unloads with the radius of the sphere",
        f"{MODEL}/dynamics/laws.py",
        "flattening = top**6 / (at_top + 6.0 * b * top**3)",
        "flattening = np.ones_like(top)",
        ("model/dynamics/test_laws",),
    ),
    Mutant(
        "viscous loss of a JKR contact without the factor 3/2",
        f"{MODEL}/dynamics/laws.py",
        "drag = 1.5 * flat(time) * unit_speed / length",
        "drag = flat(time) * unit_speed / length",
        ("model/dynamics/test_laws",),
    ),
    Mutant(
        "slip in space with the wrong spin",
        f"{MODEL}/dynamics/impact.py",
        "v[..., 1] + radius * w[..., 0]], axis=-1)",
        "v[..., 1] - radius * w[..., 0]], axis=-1)",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "energy of the spin before impact left out",
        f"{MODEL}/passes.py",
        "rotational = -change * radius * (spin + after_spin)",
        "rotational = -change * radius * after_spin",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "angle from the normal",
        f"{MODEL}/dynamics/impact.py",
        "    along = np.sin(np.radians(90.0 - angle))\n",
        "    along, angle = np.sin(np.radians(angle)), 90.0 - angle\n",
        ("model/dynamics/test_impact",),
    ),
    Mutant(
        "rolling ends when slip is used up again",
        f"{MODEL}/dynamics/trajectory.py",
        "rolling = np.maximum.accumulate(used) >= abs(slip_0)",
        "rolling = used >= abs(slip_0)",
        ("model/dynamics/test_trajectory",),
    ),
    Mutant(
        "facets leaning away from the sphere",
        f"{MODEL}/passes.py",
        "return size * (y * across - x * along)",
        "return size * (y * across + x * along)",
        ("lab/test_surface",),
    ),
    Mutant(
        "facets hit whatever they face",
        f"{MODEL}/passes.py",
        "    if facets == SEEN:",
        "    if facets == EVERY:",
        ("lab/test_surface",),
    ),
    Mutant(
        "facets weighted by the wrong moment of the slope",
        f"{LAB}/surface.py",
        "    first = mass * 0.5 * (edges[1:] + edges[:-1])",
        "    first = mass * np.abs(0.5 * (edges[1:] + edges[:-1]))",
        ("lab/test_surface",),
    ),
    Mutant(
        "no second contact",
        f"{LAB}/surface.py",
        "moving = moving[~stays & (velocity[moving, 2] <= 0.0)]",
        "moving = moving[:0]",
        ("lab/test_surface",),
    ),
    Mutant(
        "an experiment that goes on after its last event",
        f"{LAB}/experiment.py",
        "return accepted >= self.events or",
        "return accepted > self.events or",
        ("lab/ptis/test_oblique_incidence",),
    ),
    Mutant(
        "moment of hysteresis: 3/8 for 3/16",
        f"{MODEL}/dynamics/rolling.py",
        "return 3.0 / 16.0 * loss * contact_radius",
        "return 3.0 / 8.0 * loss * contact_radius",
        ("model/dynamics/test_rolling",),
    ),
    Mutant(
        "energy of rolling without spin",
        f"{MODEL}/dynamics/rolling.py",
        "energy = 0.5 * (1.0 + INERTIA) * contact.mass * np.square(velocity)",
        "energy = 0.5 * contact.mass * np.square(velocity)",
        ("model/dynamics/test_rolling",),
    ),
)

# The virtual laboratory, statistics, designs and random numbers.
COMPLIANCE = (
    Mutant(
        "tangential compliance: what joins the contact is strained already",
        f"{MODEL}/dynamics/tangential.py",
        "(0.5 * way if entering and i == count - 1 else way)",
        "(way if i < count else way) + (springs[2, 0] if entering and i == count - 1 else 0.0)",
        ("model/dynamics/test_tangential",),
    ),
    Mutant(
        "tangential compliance: (2 - nu) without its 2",
        f"{MODEL}/dynamics/tangential.py",
        "2.0 * (1.0 + np.asarray(m.poissons_ratio)) * (2.0 - m.poissons_ratio)",
        "2.0 * (1.0 + np.asarray(m.poissons_ratio)) * (1.0 - m.poissons_ratio)",
        ("model/dynamics/test_tangential",),
    ),
    Mutant(
        "tangential compliance: pressure even over the contact",
        f"{MODEL}/dynamics/tangential.py",
        "most = density * max(s * s - springs[0, i], 0.0)",
        "most = density * s * s / 1.5",
        ("model/dynamics/test_tangential",),
    ),
    Mutant(
        "tangential compliance: the force stays while the contact shrinks",
        f"{MODEL}/dynamics/tangential.py",
        "        x = springs[2, 0] + way\n        if entering:",
        "        x = springs[2, 0] * before / max(s, 1e-9) + way\n        if entering:",
        ("model/dynamics/test_tangential",),
    ),
)

LABORATORY = (
    Mutant(
        "pairs: each rebound one record late",
        f"{LAB}/pdpa/pairing.py",
        "return incident, up[np.repeat(first, number) + within]",
        "return incident, up[np.minimum(np.repeat(first, number) + within + 1, up.size - 1)]",
        ("lab/pdpa/test_pairing",),
    ),
    Mutant(
        "pairs: the last candidate of each left out",
        f"{LAB}/pdpa/pairing.py",
        "    number = last - first\n",
        "    number = np.maximum(last - first - 1, 0)\n",
        ("lab/pdpa/test_pairing",),
    ),
    Mutant(
        "pairs: sizes not compared",
        f"{LAB}/pdpa/pairing.py",
        "cost = np.square(growth[inside]) + np.square(lateness[inside])",
        "cost = np.square(lateness[inside])",
        ("lab/pdpa/test_pairing",),
    ),
    Mutant(
        "interval: as many degrees of freedom as events",
        "src/microimpact/statistics/intervals.py",
        "t = stdtrit(events - 1 if freedom is None else freedom, 0.5 * (1.0 + level))",
        "t = stdtrit(events if freedom is None else freedom, 0.5 * (1.0 + level))",
        ("lab/test_dispenser", "lab/test_reduction", "statistics/test_intervals"),
    ),
    Mutant(
        "interval: one-sided",
        "src/microimpact/statistics/intervals.py",
        "t = stdtrit(events - 1 if freedom is None else freedom, 0.5 * (1.0 + level))",
        "t = stdtrit(events - 1 if freedom is None else freedom, level)",
        ("lab/test_dispenser", "lab/test_reduction", "statistics/test_intervals"),
    ),
    Mutant(
        "camera: gravity upwards",
        f"{LAB}/ptis/system.py",
        "return gravity * np.array([np.cos(alpha), 0.0, -np.sin(alpha)])",
        "return gravity * np.array([np.cos(alpha), 0.0, np.sin(alpha)])",
        ("lab/ptis/test_ptis", "lab/ptis/test_tracks"),
    ),
    Mutant(
        "camera: no noise of the light itself",
        f"{LAB}/ptis/frames.py",
        "level / instrument.electrons_per_count + instrument.read_noise_counts**2",
        "0.0 * level + instrument.read_noise_counts**2",
        ("lab/ptis/test_ptis",),
    ),
    Mutant(
        "spots: pixels that touch by a corner are apart",
        f"{LAB}/ptis/tracks.py",
        "scipy.ndimage.label(bright[box], np.ones((3, 3)))",
        "scipy.ndimage.label(bright[box])",
        ("lab/ptis/test_spots",),
    ),
    Mutant(
        "tracks: gravity gains speed after the surface",
        f"{LAB}/ptis/tracks.py",
        "return self.velocity - self.contact[..., None] * [0.0, self.gravity]",
        "return self.velocity + self.contact[..., None] * [0.0, self.gravity]",
        ("lab/ptis/test_tracks",),
    ),
    Mutant(
        "error model of imaging: no jitter of the pulses",
        f"{LAB}/ptis/errors.py",
        "each = [jitter * velocity, noise[0] * direction, noise[1] * aside]",
        "each = [0.0 * velocity, noise[0] * direction, noise[1] * aside]",
        ("lab/ptis/test_ptis_model", "article/test_ptis"),
    ),
    Mutant(
        "drop height: factor 2 missing",
        f"{LAB}/dispenser.py",
        "return (speed**2 - exit_speed**2) / (2.0 * gravity)",
        "return (speed**2 - exit_speed**2) / gravity",
        ("lab/test_dispenser",),
    ),
    Mutant(
        "sum of twelve numbers: mean 6 left in",
        "src/microimpact/statistics/sampling.py",
        "return _inside(scipy.special.ndtr(part.sum(axis=1) - SUMMANDS / 2))",
        "return _inside(scipy.special.ndtr(part.sum(axis=1) - SUMMANDS / 2 + 0.5))",
        ("statistics/test_distributions", "studies/test_monte_carlo"),
    ),
    Mutant(
        "design: runs in the library's order",
        "src/microimpact/statistics/effects.py",
        "rows: FloatArray = design[order]",
        "rows: FloatArray = design[order[::-1]]",
        ("statistics/test_designs",),
    ),
    Mutant(
        "design: half effects",
        "src/microimpact/statistics/effects.py",
        "2.0 / len(design) * np.asarray(response) @ contrasts",
        "1.0 / len(design) * np.asarray(response) @ contrasts",
        ("studies/test_doe",),
    ),
    Mutant(
        "design: product of words as their union",
        "src/microimpact/statistics/effects.py",
        "set(first) ^ set(second)",
        "set(first) | set(second)",
        ("studies/test_doe",),
    ),
    Mutant(
        "design: Lenth's degrees of freedom m for m/3",
        "src/microimpact/statistics/effects.py",
        "stdtrit(sizes.size / 3.0, [one, together])",
        "stdtrit(sizes.size, [one, together])",
        ("studies/test_doe",),
    ),
    Mutant(
        "Monte Carlo: scatter of the sums for that of their ratio",
        f"{STUDIES}/analyses/monte_carlo/ensembles.py",
        "scatter = sums[:, first] - average * sums[:, passes.ACCEPTED]",
        "scatter = sums[:, first] - np.mean(sums[:, first])",
        ("studies/test_monte_carlo",),
    ),
    Mutant(
        "random numbers: parts of an analysis share one stream",
        "src/microimpact/statistics/distributions.py",
        "return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))",
        "return np.random.default_rng(np.random.SeedSequence(seed))",
        (
            "statistics/test_distributions",
            "studies/test_campaign",
            "lab/test_dispenser",
            "lab/pdpa/test_pdpa",
        ),
    ),
    Mutant(
        "random numbers: keys swapped",
        "src/microimpact/statistics/distributions.py",
        "return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))",
        "return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key[::-1]))",
        table="normal_experiments",
    ),
    Mutant(
        "random numbers: replicate and number of points swapped",
        f"{STUDIES}/models/fit_coverage/truths.py",
        "key = (ANALYSIS, use, points, replicate)",
        "key = (ANALYSIS, use, replicate, points)",
        table="fit_coverage",
    ),
    Mutant(
        "fits: constants left in the units of the fit",
        f"{MODEL}/empirical/search.py",
        "    parameters[:, [0, 2, V_C]] *= sets.unit[:, None]",
        "    parameters[:, [V_C]] *= sets.unit[:, None]",
        ("model/empirical/test_restitution_fit",),
    ),
    Mutant(
        "fits: captured spheres miss below v_c, as by the printed form",
        f"{MODEL}/empirical/kernel.py",
        "                kept = kept if rebounds else 0.0",
        "                kept = kept if rebounds else 0.5",
        ("model/empirical/test_search",),
    ),
)

MUTANTS = MISPRINTS + SLIPS + COMPLIANCE + LABORATORY
