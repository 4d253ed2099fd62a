"""Figs. 1 to 3, 13, 19, 22: set-ups, impacts and contacts as schematics."""

from __future__ import annotations

from typing import TYPE_CHECKING

from study.figures.declaration import figure

if TYPE_CHECKING:
    from study.figures.style import Sheet


@figure(
    "fig01",
    "Set-up of the oblique impacts",
    """
        The particle trajectory imaging system. (a) Seen along the camera's axis: spheres fall
        through a light sheet that a disk with [[set_ups.disk_slots]] slots interrupts and
        strike a tilted target. Directions and dashes of both tracks are to scale, by the rigid
        body model at [[set_ups.target_angle_deg:.0f]]°. (b) Seen from above. Positions of the
        parts are schematic.
    """,
    {"side": "seen along the axis of the camera", "top": "seen from above"},
    data=("fig01",),
    equations="6, 7",
    article="""
        A schematic of the equipment for oblique impacts: laser, chopper, dispenser, tilted
        target, camera.
    """,
    height_mm=128.0,
    is_schematic=True,
)
def draw_fig01(sheet: Sheet) -> None:
    """From the side and from above, in mm."""
    from study.analyses.fig01_03_13_19_22_schematics import parts, set_ups

    side = {
        "laser": "argon-ion laser",
        "collimator": "collimator",
        "disk": "beam chopper:\nspinning disk with\n[[set_ups.disk_slots]] slots, front view",
        "lens": "plano-convex\nlens",
        "light sheet": "pulsed\nlight sheet",
        "vacuum cell": "vacuum test cell,\n$10^{[[set_ups.log10_pressure_torr:.0f]]}$ Torr",
        "dispenser": "particle dispenser\n(neutral charge)",
        "rotor": "rotor",
        "needle": "hypodermic needle",
        "drop height": "[[set_ups.least_drop_height_m:g]] to\n"
        "[[set_ups.greatest_drop_height_m:.1f]] m",
        "incident track": "incident",
        "rebound track": "rebound",
        "target": "target surface,\ngrounded",
        "angle": r"$\alpha$",
    }
    top = {
        "camera": "CCD camera",
        "recorder": "video recorder",
        "porthole": "porthole",
        "light sheet": "light sheet",
        "sphere": "sphere",
        "angle": "≈ [[set_ups.camera_angle_deg:.0f]]°",
    }
    frame, ends = (0.0, 49.0, 174.0, 76.0), ((0.0, 174.0), (0.0, 76.0))
    set_ups.imaging_side(parts.view(sheet, "side", frame, ends, side))
    frame, ends = (0.0, 6.0, 174.0, 42.0), ((0.0, 174.0), (0.0, 42.0))
    set_ups.imaging_top(parts.view(sheet, "top", frame, ends, top))
    parts.key(sheet)


@figure(
    "fig02",
    "Set-up of the normal impacts",
    """
        The phase Doppler particle analyser. (a) Seen from above: two pairs of beams, one for
        each velocity component, cross in the probe volume above the target. The receiver
        collects side scatter at [[set_ups.receiver_angle_deg:.0f]]°; the phases at its
        [[set_ups.detectors]] detectors give the diameter. (b) The probe volume, which a sphere
        crosses before and after its impact. Positions are schematic.
    """,
    {"top": "seen from above", "side": "probe volume, enlarged"},
    data=("fig02",),
    article="""
        A schematic, seen from above, of the equipment for normal impacts with the phase Doppler
        analyser.
    """,
    is_schematic=True,
)
def draw_fig02(sheet: Sheet) -> None:
    """From above, and the probe volume from the side, in mm."""
    from study.analyses.fig01_03_13_19_22_schematics import parts, set_ups

    top = {
        "laser": "argon-ion\nlaser, [[set_ups.shortest_wavelength_nm:.0f]]\n"
        "to [[set_ups.longest_wavelength_nm:.0f]] nm",
        "beam splitter": "beam\nsplitter",
        "frequency shifter": "frequency\nshifting",
        "transmitting lens": "transmitting\nlens",
        "horizontal pair, upper": "beam pair for the horizontal velocity",
        "vertical pair": "beam pair for the vertical velocity (one above the other)",
        "vacuum cell": "vacuum\ntest cell",
        "probe volume": "probe\nvolume",
        "target": "target\nsurface",
        "receiving lens": "receiving lens",
        "detectors": "receiver with\n[[set_ups.detectors]] detectors",
        "data file": "data file",
        "angle": "[[set_ups.receiver_angle_deg:.0f]]°",
    }
    side = {
        "needle": "hypodermic\nneedle",
        "incident": "incident\nsphere",
        "rebound": "rebound",
        "target": "target surface",
        "probe height": "$h$ ≈\n[[set_ups.probe_height_mm:g]] mm",
    }
    frame, ends = (0.0, 6.0, 128.0, 72.0), ((0.0, 128.0), (0.0, 72.0))
    set_ups.analyser_top(parts.view(sheet, "top", frame, ends, top))
    frame, ends = (128.0, 6.0, 46.0, 72.0), ((0.0, 46.0), (0.0, 72.0))
    set_ups.analyser_side(parts.view(sheet, "side", frame, ends, side))
    parts.key(sheet)


@figure(
    "fig03",
    "Variables of a planar impact",
    """
        Velocities before (lower case) and after (capitals) the impact, axes n and t, and the
        angle of incidence alpha from the surface. Arrows are to scale for the rigid body model
        at [[rebound.speed_m_per_s:.2f]] m/s, alpha = [[rebound.angle_deg:.0f]]°, e =
        [[rebound.restitution:.2f]], f = [[rebound.friction:.2f]] and r omega / v =
        [[rebound.spin_ratio:.2f]]. Spins are arcs as long as the rim's path.
    """,
    {"impact": ""},
    data=("fig03",),
    equations="1, 2, 3, 6, 7, 8",
    article="The velocities, spins and angles of a planar impact and the axes they refer to.",
    method="""
        Spin is positive in the sense of rolling along t; friction changes it. The measured
        quantities are e = -V_n/v_n, mu = (V_t - v_t)/(V_n - v_n) and the loss of translational
        energy.
    """,
    width="single",
    height_mm=61.0,
    is_schematic=True,
)
def draw_fig03(sheet: Sheet) -> None:
    """Velocities of both legs, as long as there is room for."""
    from study.analyses.fig01_03_13_19_22_schematics import impacts, parts

    words = {
        "incident velocity": "$v$",
        "incident tangential": "$v_t$",
        "incident normal": "$v_n$",
        "incident spin": r"$r\omega$",
        "rebound velocity": "$V$",
        "rebound tangential": "$V_t$",
        "rebound normal": "$V_n$",
        "rebound spin": r"$r\Omega$",
        "angle": r"$\alpha$",
    }
    frame, ends = (0.0, 6.0, 86.0, 55.0), ((-1.3, 1.3), (-0.3, 1.3628))
    scale = impacts.fitting(sheet.tables["fig03"])
    impacts.velocities(parts.view(sheet, "impact", frame, ends, words, scale))
    parts.key(sheet)


@figure(
    "fig13",
    "Free body diagram of the rigid body model",
    """
        Momentum of the sphere before impact plus the impulses of the contact give its momentum
        after impact, all divided by m and drawn to one scale, for the impact of Fig. 3.
        Friction opposes the slip of the contact point C: its impulse is mu times the normal
        one. The model leaves out the impulsive moment M.
    """,
    {
        "before": "before the impact",
        "impulse": "impulses during contact",
        "after": "after the impact",
    },
    data=("fig13",),
    equations="4, 6, 7, 8",
    article="Impulses and velocities on a sphere in the rigid body model.",
    height_mm=83.0,
    is_schematic=True,
)
def draw_fig13(sheet: Sheet) -> None:
    """Momenta and impulses, as a sum, to one scale."""
    from study.analyses.fig01_03_13_19_22_schematics import impacts, parts

    before = {
        "tangential": "$m v_t$",
        "normal": "$m v_n$",
        "spin": r"$I\omega$",
    }
    impulse = {
        "tangential": r"$P_t = \mu P_n$",
        "normal": "$P_n$",
        "moment": "$M$, neglected",
        "radius": "$r$",
        "contact point": "$C$",
    }
    after = {
        "tangential": "$m V_t$",
        "normal": "$m V_n$",
        "spin": r"$I\Omega$",
        "scale": "m/s × $m$",
    }
    ends, scale = ((-0.72, 1.22), (-1.06, 1.5155)), impacts.fitting(sheet.tables["fig13"])
    views = [
        parts.view(sheet, name, (left, 6.0, 58.0, 77.0), ends, words, scale)
        for name, left, words in (
            ("before", 0.0, before),
            ("impulse", 58.0, impulse),
            ("after", 116.0, after),
        )
    ]
    impacts.momentum_balance(*views)
    parts.key(sheet)


@figure(
    "fig19",
    "Stresses on the contact at its greatest compression",
    """
        A sphere of [[contact.diameter_um:.1f]] µm of [[contact.case.pair]] at the greatest
        compression of a normal impact at [[contact.speed_m_per_s:.1f]] m/s. (a) Section to
        scale; dashed, the undeformed sphere. (b) Stresses on the sphere: Hertz pressure over
        the contact radius a pushes it away; the ring force f_0 per length of the edge, on its
        own scale, pulls it on.
    """,
    {"section": "section", "stresses": "stresses on the sphere"},
    data=("fig19", "fig19_pressure", "fig19_ring"),
    equations="3.2 contact radius, 20, 22, 30",
    article="""
        A sketch of the stresses on the contact: the pressure of Hertz, and adhesion as a
        tension on a ring around it.
    """,
    method="""
        Contact [[contact.case]]. At this instant the normal velocity is zero, so the damping
        forces are zero.
    """,
    height_mm=78.0,
    is_schematic=True,
)
def draw_fig19(sheet: Sheet) -> None:
    """Lengths in multiples of the radius of the sphere, or of the contact."""
    from study.analyses.fig01_03_13_19_22_schematics import contact, parts

    section = {
        "contact": "$a$",
        "free shape": "$-n$",
        "radius": "$r$",
        "spin": r"$\theta$",
    }
    stresses = {
        "pressure": "$p_0$",
        "ring tension": "$f_0$",
        "contact radius": "$a$",
    }
    rows = sheet.tables["fig19"]
    radius = float(rows.loc[rows["series"] == "free shape", "x_um"].max())
    frame, ends = (0.0, 6.0, 76.0, 72.0), ((-1.346, 1.346), (-0.345, 2.205))
    contact.section(parts.view(sheet, "section", frame, ends, section, radius))
    pressure = sheet.tables["fig19_pressure"][["x_um", "y_GPa"]].to_numpy(float)
    tension = float(sheet.tables["fig19_ring"]["y_N_per_m"].abs().max())
    frame, ends = (76.0, 6.0, 98.0, 72.0), ((-1.76, 1.19), (-1.33, 0.838))
    contact.stresses(parts.view(sheet, "stresses", frame, ends, stresses), pressure, tension)
    parts.key(sheet)


@figure(
    "fig22",
    "Angles on a wavy surface",
    """
        A sphere strikes a wavy surface at the nominal angle alpha =
        [[wavy_surface.angle_deg:.0f]]°, where the surface faces it at the slope phi. Relative
        to the local axes t' and n' it strikes at alpha + phi, and the velocities measured along
        t and n mix those along t' and n'. Sphere ([[wavy_surface.diameter_um:.0f]] µm) and
        surface are to one scale.
    """,
    {"geometry": ""},
    data=("fig22",),
    equations="35, 36",
    article="""
        How the apparent angle of incidence and normal differ from the true ones on a surface
        that is not flat.
    """,
    method="""
        Wavelength [[wavy_surface.wavelength_um:.0f]] µm, amplitude
        [[wavy_surface.amplitude_um:.0f]] µm. A slope that turns away has phi < 0.
    """,
    width="single",
    height_mm=66.0,
    is_schematic=True,
)
def draw_fig22(sheet: Sheet) -> None:
    """In multiples of half the length of the surface, a wavelength."""
    from study.analyses.fig01_03_13_19_22_schematics import impacts, parts

    words = {
        "incident velocity": "$v$",
        "angle": r"$\alpha$",
        "local angle": r"$\alpha + \phi$",
        "slope": r"$\phi$",
        "nominal tangent": "$t$",
        "nominal normal": "$n$",
        "local tangent": "$t$′",
        "local normal": "$n$′",
        "mean plane": "nominal surface",
        "surface": "true surface",
    }
    rows = sheet.tables["fig22"]
    wavelength = float(rows.loc[rows["series"] == "surface"].iloc[:, 3].max())
    frame, ends = (0.0, 6.0, 86.0, 60.0), ((-0.65, 0.56), (-0.3, 0.544))
    impacts.wavy_surface(parts.view(sheet, "geometry", frame, ends, words, wavelength))
    parts.key(sheet)
