"""Files of trackers are read as they are; bad ones are refused in one line."""

from __future__ import annotations

import numpy as np
import pytest

from microimpact import read_rebounds, read_records
from microimpact.core.constants import gravity

FPS, UM_PER_PX = 5000.0, 10.0


def points(tracks=3):
    """Frame, column, row (down, px) and number of the track, of falls with e = 0.6."""
    rows = []
    for i in range(tracks):
        for frame in range(20):
            t = (frame - 9.6) / FPS
            x, y = 0.2 * t, (-1.0 if t < 0 else 0.6) * t - 0.5 * gravity * t**2
            rows.append((frame, 100.0 * (i + 1) + 1e5 * x, 300.0 - 1e5 * y, i))
    return rows


def trackmate():
    """Three rows of headers, and one of units."""
    head = ["LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_T,FRAME,RADIUS"]
    head += ["Label,Spot ID,Track ID,Quality,X,Y,T,Frame,Radius"]
    head += [
        "Label,Spot ID,Track ID,Quality,X,Y,T,Frame,R",
        ",,,(quality),(pixel),(pixel),(sec),,(pixel)",
    ]
    rows = [f"ID{n},{n},{k},5.1,{x},{y},{f},{f},3.1" for n, (f, x, y, k) in enumerate(points())]
    return "\n".join(head + rows)


def tracker():
    """A title, and metres upwards; one sphere."""
    rows = [f"{f / FPS}\t{1e-5 * x}\t{1e-5 * (300 - y)}" for f, x, y, _ in points(1)]
    return "\n".join(["mass_A\t\t", "t\tx\ty", *rows])


def trackpy():
    """An index in front, columns of the spot, order of frames."""
    rows = sorted((f, k, x, y) for f, x, y, k in points())
    lines = [f"{n},{y},{x},900.5,2.1,0.1,88.0,{f},{k}" for n, (f, k, x, y) in enumerate(rows)]
    return "\n".join([",y,x,mass,size,ecc,signal,frame,particle", *lines])


def dltdv():
    """A row a frame, blank where nothing is digitised."""
    rows = [f"{x},{480 - y}" for _, x, y, _ in points(1)]
    return "\n".join(["pt1_cam1_X,pt1_cam1_Y", "NaN,NaN", *rows, "NaN,NaN"])


def imagej():
    rows = [
        f" {n}\t{k + 1}\t{f + 1}\t{x:.4f}\t{y:.4f}\t-1\t-1\t12"
        for n, (f, x, y, k) in enumerate(points())
    ]
    return "\n".join([" \tTrack n°\tSlice n°\tX\tY\tDistance\tVelocity\tPixel Value", *rows])


def own():
    """Semicolons, decimal commas, a row of units, blank lines."""
    rows = [f"{1e3 * f / FPS};{x / 100};{y / 100};{k}".replace(".", ",") for f, x, y, k in points()]
    return "\n".join(["# camera 2", "Time;x;y;Track", "ms;mm;mm;", *rows[:20], "", *rows[20:]])


@pytest.mark.parametrize(
    ("text", "options", "tracks"),
    [
        (trackmate, {"fps": FPS, "um_per_px": UM_PER_PX}, 3),
        (tracker, {"y": "up", "size_unit": "m"}, 1),
        (trackpy, {"fps": FPS, "um_per_px": UM_PER_PX}, 3),
        (dltdv, {"fps": FPS, "um_per_px": UM_PER_PX, "y": "up"}, 1),
        (imagej, {"fps": FPS, "um_per_px": UM_PER_PX}, 3),
        (own, {}, 3),
    ],
    ids=lambda of: getattr(of, "__name__", ""),
)
def test_files_as_trackers_write_them(text, options, tracks, tmp_path):
    path = tmp_path / "tracks.csv"
    path.write_text(text(), encoding="utf-8")
    found = read_records(path, wall="0", **options)
    assert found.reduced.e == pytest.approx(np.full(tracks, 0.6), rel=1e-3)
    assert found.reduced.v == pytest.approx(np.full(tracks, np.hypot(1.0, 0.2)), rel=1e-3)
    assert not any("fall" in note for note in found.notes)
    if text is trackmate:
        assert found.reduced.d == pytest.approx(np.full(tracks, 62e-6))


def frames(**changes):
    frame, x, y, track = (list(column) for column in zip(*points(), strict=True))
    return {"frame": frame, "x": x, "y": y, "track": track} | changes


OPTIONS = {"fps": FPS, "um_per_px": UM_PER_PX, "wall": 0.0}


@pytest.mark.parametrize("wall", [0.0, "find", "0,300,640,300"])
def test_the_wall_has_three_forms(wall):
    found = read_records(frames(), **OPTIONS | {"wall": wall}).reduced
    assert found.e == pytest.approx(np.full(3, 0.6), rel=1e-3)


def test_two_points_of_a_wall_turn_with_y():
    turned = [read_records(frames(), **OPTIONS | {"wall": wall}).reduced.e
              for wall in ("0,300,100,290", np.degrees(np.arctan(0.1)))]  # fmt: skip
    assert turned[0] == pytest.approx(turned[1], rel=1e-9)


def test_the_result_goes_into_a_fit():
    rng = np.random.default_rng(1)
    noisy = frames(**{k: np.array(frames()[k]) + 0.05 * rng.standard_normal(60) for k in "xy"})
    bad = {k: [*noisy[k], *list(noisy[k])[:4]] for k in noisy} | {
        "track": [*noisy["track"], *4 * [9]]
    }
    found = read_records(bad, **OPTIONS, tilt=0.25)
    assert "3 impacts in 4 tracks, 0 captured; 1 left out: 1 4 points" in found.read
    data = read_rebounds(found.reduced.columns)
    assert data.v == pytest.approx(np.ones(3), rel=0.02)
    assert data.e == pytest.approx(np.full(3, 0.6), rel=0.02)
    spread = found.reduced.sigma_v[:3] * np.sin(np.radians(found.reduced.angle[:3]))
    assert data.sigma_v == pytest.approx(spread)
    assert np.all(data.sigma >= found.reduced.sigma[:3])


@pytest.mark.parametrize("options", [{"y": "up"}, {"um_per_px": 40.0}, {"fps": 20e3}])
def test_a_wrong_scale_rate_or_direction_is_doubted(options):
    slow = 20.0  # long flights show their fall
    t = [(f - 9.6) / FPS * slow for f, *_ in points(1)]
    y = [300.0 - 1e5 * ((-0.5 if s < 0 else 0.4) * s - 0.5 * gravity * s**2) for s in t]
    y = (np.array(y) + 0.1 * np.random.default_rng(4).standard_normal(20)).tolist()
    data = {"frame": [*range(20)], "x": [100.0] * 20, "y": y}
    right = OPTIONS | {"fps": FPS / slow}
    assert not read_records(data, **right).notes
    wrong = right | {k: v / slow if k == "fps" else v for k, v in options.items()}
    assert any("the paths fall with" in note for note in read_records(data, **wrong).notes)


@pytest.mark.parametrize(
    ("data", "options", "message"),
    [
        (frames(), {"wall": None}, "give --wall: an angle in degrees, 'x1,y1,x2,y2' or find"),
        (frames(), {"wall": "up"}, "two points 'x1,y1,x2,y2' or find, got 'up'"),
        (frames(), {"wall": "1,1,1,1"}, "two points 'x1,y1,x2,y2' or find, got '1,1,1,1'"),
        (frames(), {"fps": None}, "without a column t give --fps"),
        (frames(), {"fps": -1.0}, "--fps must be finite and > 0, got -1"),
        (frames(), {"um_per_px": None}, "x is in px; give --um-per-px"),
        (frames(), {"drag": 2500.0}, "data holds tracks; leave out --drag"),
        (frames(), {"gravity": "up"}, "--gravity must be down or none, got 'up'"),
        (frames(x=[*frames()["x"][:-1], "?"]), {}, "row 59: x must be a number, got '?'"),
        (frames(d=[62.0] * 60), {}, "d needs a unit in the header: 'd (um)'"),
        ({"h0 (mm)": [100], "h1 (mm)": [-1]}, dict.fromkeys(OPTIONS), "h1 must be 0 or more"),
        ({"h0": [100], "h1": [1]}, dict.fromkeys(OPTIONS), "h0 is in px; give --um-per-px"),
        ({"h0 (mm)": [9], "h1 (mm)": [3]}, dict.fromkeys(OPTIONS) | {"drag": 9.0}, "--drag needs"),
        ({"t (ms)": [0, 2, 1]}, dict.fromkeys(OPTIONS), "row 2: t must ascend, got 1"),
        ({"t (ms)": [0, 2]}, dict.fromkeys(OPTIONS), "three bounces are needed of a sphere, got 2"),
        ({"a": [0, 2]}, {}, "the columns x, y and frame or t are needed, or h0 and h1, or t alone"),
    ],
)
def test_bad_records_are_refused(data, options, message):
    with pytest.raises(ValueError) as refused:  # noqa: PT011
        read_records(data, **OPTIONS | options)
    assert message in str(refused.value)
