"""Breaks of the claims on measurements: what is changed before numbers are computed again."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from tests.article.claim_worlds import STEEL, ClaimWorld, changed, nothing, to

from microimpact.declared.parameters import build
from microimpact.lab import collision
from microimpact.lab.contacts import calibrated_contact
from microimpact.lab.samples import Sampling, contact_of
from microimpact.model.calibration import damping_factor_for
from microimpact.model.dynamics.impact import spatial
from microimpact.model.dynamics.normal import normal_impact
from microimpact.studies.experiments import mechanisms, pair_search, track_imaging
from microimpact.studies.experiments.mechanisms import spore as _spore_mechanism
from microimpact.studies.experiments.mechanisms.shallow import adhesion_or_roughness, shallow_curves
from microimpact.studies.experiments.mechanisms.slope import formica_comparison, pair_rows
from microimpact.studies.experiments.mechanisms.speed_and_angle import (
    class_row,
    loss_slopes,
    resolution,
)
from microimpact.studies.experiments.mechanisms.spore import comparison, smooth_spore, spore_tables

FORMICA_SPORE = "lycopodium-formica"

# Breaks whose verdict is found without them already, so that they show nothing.
MUTE = {
    "C74": "at 70 deg the loss has 0.88 of the squares: four error bars, on flat surfaces too",
    "C79": "from 40 to 1000 events per mean the loss departs at too shallow or too steep angles",
    "C83": "collisions off the centre lower restitution by five error bars, whatever the slopes",
    "C84": "no cause tried turns the rise below 15 deg, of three error bars, into a fall",
}


class World(ClaimWorld):
    """Numbers behind the claims on measurements."""

    study = "laboratory_claims"

    def mechanisms(self):
        """Return the parameters of the mechanisms and their sampling."""
        params = build(mechanisms.Params, self.settings.branches["mechanisms"])
        return params, Sampling(
            seed=params.seed,
            impacts=params.impacts,
            events=params.events,
            angle_error_deg=params.instrument.angle_error_deg,
            dispenser=params.dispenser,
        )

    def own(self, study, module, **changes):
        """Return parameters of another study with changes."""
        return build(module.Params, {**self.settings.branches[study], **changes})


def without_ring_force(claim, world):
    return world.numbers(claim, world.calibration(STEEL, work_of_adhesion=nothing))


def ptis_range(world, **changes):
    small = {"angles_deg": [45.0], "modelled_events": 20, "drawn_angle_deg": 45.0}
    params = world.own("track_imaging", track_imaging, **small, **changes)
    return {"ptis_range": pd.DataFrame(track_imaging.search(params))}


def narrow_speeds(claim, world):
    speeds = np.linspace(1.0, 3.0, 6).tolist()
    return world.numbers(claim, ptis_range(world, speeds_m_per_s=speeds))


def pairing(world, *heights):
    """Return the quality at these heights; 300 pairs at 0.3 m/s from 1 mm, some 40 from 2 mm."""
    changes = {"heights_mm": heights, "speeds_m_per_s": [0.3, 0.75, 1.66]}
    params = world.own("pair_search", pair_search, experiments=60, **changes)
    setup = pair_search.Setup(
        seed=params.seed,
        contact=calibrated_contact(world.inputs(), params.case),
        diameter_um=params.diameter_um,
        dispenser=params.dispenser,
        instrument=params.instrument,
    )
    return {"pairing_quality": pair_search.pairing_quality(params, setup)[0]}


def near_heights(claim, world):
    return world.numbers(claim, pairing(world, 0.95, 1.05))


def coverage(world, **pdpa):
    """One speed or angle on the smooth surface, repeated as often as in the full study."""
    branch = world.settings.branches["interval_coverage"]
    normal, oblique, _ = branch["cases"]
    cases = [normal | {"speeds_m_per_s": [0.3]}, oblique | {"angles_deg": [30.0]}]
    changes = {"cases": cases, "pdpa": branch["pdpa"] | pdpa, "experiments": 2000}
    return dict(world.run_study("interval_coverage", world.tables, **changes))


def near_probe(claim, world):
    tables = coverage(world, probe_height_mm=0.1, probe_height_error_um=5.0)
    return world.numbers(claim, tables)


def pile_up(world, radius, **dispenser):
    dispenser = {**world.settings.branches["pile_up"]["dispenser"], **dispenser}
    changes = {"radii_mm": [radius], "drawn_radius_mm": radius, "slopes_deg": [2.0]}
    return dict(
        world.run_study("pile_up", world.tables, spheres=400, dispenser=dispenser, **changes)
    )


def small_target(claim, world):
    """A target of 0.1 mm, and a stream narrow enough to hit it."""
    narrow = {"lateral_position_mm": 0.01, "lateral_speed_m_per_s": 0.001}
    return world.numbers(claim, pile_up(world, 0.1, **narrow))


def larger_diameters(claim, world):
    larger = world.settings.branches["laboratory_claims"]["sieves"]["larger_um"]
    return world.numbers(claim, sieves={"smaller_um": larger})


def pairs(claim, world, name, **changes):
    """Run one pair of surfaces again."""
    params, sampling = world.mechanisms()
    chosen = [pair for pair in params.slope.pairs if pair.name == name]
    others = world.tables["surface_pairs"]
    slope = replace(params.slope, pairs=tuple(mended(pair, **changes) for pair in chosen))
    new = pd.DataFrame(pair_rows(slope, sampling, world.inputs()))
    kept = others[others["pair"] != name]
    return world.numbers(claim, {"surface_pairs": pd.concat([kept, new])})


def mended(pair, adhesion_factor=None, **rough):
    factor = pair.adhesion_factor if adhesion_factor is None else adhesion_factor
    return replace(pair, adhesion_factor=factor, rough=replace(pair.rough, **rough))


def restitution_of_0_90(claim, world):
    tables = {}
    for case in STEEL:
        contact = calibrated_contact(world.inputs(), case)
        mended = damping_factor_for(contact, 1.60, 0.90)
        dampings = {
            name: to(float(getattr(mended, name))) for name in ("hertz_damping", "adhesion_damping")
        }
        world.tables = world.tables | world.calibration((case,), **dampings)
    params, sampling = world.mechanisms()
    rows = []
    for case in STEEL:
        base = replace(params.speed.dropped, case=case)
        contact = contact_of(base, world.inputs())
        rows += [
            class_row(params.speed, base, contact, one, sampling) for one in params.speed.classes
        ]
    tables["speed_and_angle"] = pd.DataFrame(rows)
    return world.numbers(claim, tables)


def strong_friction(claim, world):
    params, _ = world.mechanisms()
    table = pd.DataFrame(loss_slopes(replace(params.speed, loss_frictions=(1.0, 2.0, 3.0))))
    return world.numbers(claim, {"loss_slopes": table})


def strong_spore(claim, world):
    """Twice the work of adhesion after the calibration, so that the damping stays as it is."""
    plain = _spore_mechanism.met_at

    def doubled(restitution, dropped, contact, angle, sampling):
        found = plain(restitution, dropped, contact, angle, sampling)
        factor = 2.0 if dropped.particle == "lycopodium" else 1.0
        return found.replace(work_of_adhesion=factor * found.work_of_adhesion)

    world.patch.setattr(_spore_mechanism, "met_at", doubled)
    params, sampling = world.mechanisms()
    table = comparison(params.spore, sampling, world.inputs())
    return world.numbers(claim, {"spore_comparison": table})


def slower_capture(claim, world):
    params, _ = world.mechanisms()
    spore = replace(params.spore, quoted_capture_velocity_m_per_s=0.80)
    contact = contact_of(spore.spore, world.inputs())
    return world.numbers(claim, {"smooth_spore": smooth_spore(spore, contact)})


def smooth_spores(claim, world):
    params, sampling = world.mechanisms()
    spore = replace(params.spore, spore=replace(params.spore.spore, particle_slope=0.0))
    made = spore_tables(spore, sampling, params.instrument, world.inputs())
    return world.numbers(claim, {"spore_trends": made["spore_trends"]})


def shallow_loss(claim, world):
    params, sampling = world.mechanisms()
    speed = replace(params.speed, resolved_deg=20.0)
    table = pd.DataFrame([resolution(speed, sampling, world.inputs())])
    return world.numbers(claim, {"loss_resolution": table})


def formica(world, tables):
    params, sampling = world.mechanisms()
    table = formica_comparison(params.slope, sampling, world.inputs(tables))
    return {"formica_mechanism": table, **tables}


def elastic_spore(claim, world):
    """The contact of the spore with the restitution of steel at normal incidence."""
    steel, spore = (
        calibrated_contact(world.inputs(), case) for case in ("steel-formica", FORMICA_SPORE)
    )
    aim = float(normal_impact(steel, 1.66).coefficient_of_restitution)
    found = damping_factor_for(spore, 1.48, aim)
    dampings = {
        name: to(float(getattr(found, name))) for name in ("hertz_damping", "adhesion_damping")
    }
    return world.numbers(claim, formica(world, world.calibration((FORMICA_SPORE,), **dampings)))


def spore_without_adhesion(claim, world):
    bare = world.calibration((FORMICA_SPORE,), work_of_adhesion=nothing)
    return world.numbers(claim, formica(world, bare))


def net_force(claim, world):
    def by_net_force(*given, **named):
        return spatial(*given, **{**named, "friction_basis": "net"})

    world.patch.setattr(collision, "spatial", by_net_force)
    params, sampling = world.mechanisms()
    curves = shallow_curves(params.shallow, sampling, world.inputs())
    table = adhesion_or_roughness(params.shallow, curves)
    return world.numbers(claim, {"adhesion_or_roughness": table})


NARROW = {"kind": "truncated_normal", "mean": 49.0, "sd": 1.0, "low": 48.0, "high": 50.0}

BREAKS = {
    "C01": partial(changed, fall={"exit_speed_m_per_s": 0.15}),
    "C02": partial(changed, fall={"correction": "printed"}),
    "C03": partial(changed, fall={"probe_height_mm": 0.01}),
    "C04": partial(changed, fall={"pile_up_speed_m_per_s": 0.44}),
    "C15": partial(changed, slow={"spin_ratio": 0.0}),
    "C61": narrow_speeds,
    "C62": near_heights,
    "C63": near_probe,
    "C64": larger_diameters,
    "C65": partial(changed, sieves={"smaller_um": NARROW}),
    "C66": small_target,
    "C67": partial(changed, regions={"dropped": {"spin": {"sd": 0.2}}}),
    "C71": partial(pairs, name="silicon", adhesion_factor=0.5),
    "C72": partial(pairs, name="silicon", surface_slope=0.0),
    "C73": partial(pairs, name="silicon, half the adhesion", adhesion_factor=1.0),
    "C74": partial(pairs, name="mirror", case="steel-mirror front"),
    "C75": without_ring_force,
    "C76": without_ring_force,
    "C77": partial(changed, slow={"limit_spin_ratio": -0.3}),
    "C78": partial(changed, slow={"mean_spin": 1.0}),
    "C79": restitution_of_0_90,
    "C80": strong_friction,
    "C81": strong_spore,
    "C82": slower_capture,
    "C83": smooth_spores,
    "C84": smooth_spores,
    "C85": shallow_loss,
    "C86": partial(changed, mechanisms={"formica_from_deg": 20.0}),
    "C87": partial(changed, mechanisms={"formica_from_deg": 45.0}),
    "C88": elastic_spore,
    "C89": spore_without_adhesion,
    "C91": partial(changed, sampling={"angle_error_deg": 1.0}),
    "C92": net_force,
}
