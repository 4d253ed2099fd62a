"""Write ``restitution.csv``: normal impacts to 25 digits, by a formulation of their own.

The equation of motion is integrated in the phase plane of contact radius s = sqrt(x) and speed
u = dx/dt, without time and without an event to locate. Where the path is shallow u follows s,

    u du/ds = 2 s^2 (b - s^2) - 2 s^2 (b C_A + C_H s^2) u,        dt/ds = 2 s/u,

and around the turning point s follows u, by the inverse slope. Both arrive at their ends, s = 0 and
u = 0, as limits of integration. The capture speed is found on the path followed backwards from the
exit with a vanishing speed. Adhesion b is 1, in units of the velocity scale and the equilibrium
compression, or 0, with the speed of the impact as unit of speed (so w = 1).

Run from anywhere, about a minute: ``python make_restitution_reference.py``
"""

from __future__ import annotations

import csv
from pathlib import Path

from mpmath import mp, mpf

ORDER = 40
TOLERANCE = "1e-36"
LEAVING_SPEED = "1e-18"
PRINTED_DIGITS = 25
TABLE = Path(__file__).with_name("restitution.csv")
COLUMNS = (
    "adhesion",
    "w",
    "c_h",
    "c_a",
    "damped_attachment",
    "e",
    "contact_time",
    "compression",
    "capture_speed",
)

mp.dps = 40

# adhesion, w, C_H, C_A, damped attachment
IMPACTS = [
    # moderate
    (1, 0.7, 0.02, 0.1, False),
    (1, 1.5, 0.01, 0.3, False),
    (1, 2.0, 0.01, 0.3, True),
    (1, 2.0, 0.0, 0.5, False),
    (1, 2.0, 0.2, 0.0, False),
    (1, 3.0, 0.05, 0.5, False),
    (1, 6.0, 0.05, 0.5, True),
    (1, 10.0, 0.03, 0.2, False),
    (1, 25.0, 0.3, 0.3, False),
    (1, 40.0, 0.0, 1.0, False),
    # undamped
    (1, 0.01, 0.0, 0.0, False),
    (1, 2.0, 0.0, 0.0, False),
    # slow, and hardly damped
    (1, 0.001, 1e-8, 0.0, False),
    (1, 0.01, 1e-6, 1e-6, True),
    (1, 0.05, 0.0, 1e-4, False),
    # fast
    (1, 1e3, 1e-4, 1e-3, False),
    (1, 1e3, 1e-4, 1e-3, True),
    (1, 1e3, 0.0, 0.8, False),
    (1, 1e3, 0.01, 0.5, False),
    # strong damping of the material
    (1, 1e3, 0.1, 0.1, False),
    (1, 300.0, 0.3, 0.0, False),
    # no adhesion
    (0, 1.0, 0.0, 0.0, False),
    (0, 1.0, 0.01, 0.0, False),
    (0, 1.0, 1.0, 0.0, False),
    (0, 1.0, 10.0, 0.0, False),
    (0, 1.0, 100.0, 0.0, False),
]

# C_H, C_A, damped attachment, and the relative distances from the capture speed
THRESHOLDS = [
    (0.0, 0.007, False, (1e-3, 1e-6)),
    (0.004, 0.0, False, (1e-3, 1e-6)),
    (0.0, 0.1, False, (1e-3, 1e-6)),
    (0.01, 0.3, False, (1e-3, 1e-6)),
    (0.1, 0.3, True, (1e-3, 1e-6)),
    (0.3, 0.2, False, (1e-3, 1e-6)),
    (0.0, 1e-6, False, (0.5, 1e-3, 1e-6)),
    (1e-8, 0.0, False, (0.5,)),
    (0.0, 1e-10, False, (0.5,)),
    (1e-12, 1e-12, True, (0.5, 1e-3)),
]


class Captured(Exception):  # noqa: N818
    """The sphere stays."""


class PhasePath:
    """A path in the phase plane, with the state s, u and the time t so far."""

    def __init__(self, adhesion, c_h, c_a, u):
        self.b, self.c_h, self.c_a = mpf(adhesion), mpf(c_h), mpf(c_a)
        self.s, self.u, self.t = mpf(0), mpf(u), mpf(0)

    @property
    def steep(self):
        """Whether |u| falls with s and, relatively, changes faster than s."""
        p = self.s**2
        slope = 2 * p * ((self.b - p) / self.u - self.b * self.c_a - self.c_h * p)
        return -slope * self.s * self.u > self.u**2

    @property
    def energy(self):
        return self.u**2 / 2 + mpf(2) / 5 * self.s**5 - mpf(2) / 3 * self.b * self.s**3

    def series_in_s(self):
        """Taylor series of u and of the time around the present s."""
        forcing = _shifted([-2, 0, 2 * self.b, 0, 0], self.s)
        damping = _shifted([2 * self.c_h, 0, 2 * self.b * self.c_a, 0, 0], self.s)
        radius = [2 * self.s, mpf(2)] + [mpf(0)] * (ORDER - 2)
        u, rate = [self.u], []
        for k in range(ORDER):
            lost = mp.fdot((damping[j], u[k - j]) for j in range(min(k, 4) + 1))
            known = mp.fdot((j * u[j], u[k + 1 - j]) for j in range(1, k + 1))
            right = (forcing[k] if k <= 4 else 0) - lost - known
            u.append(right / ((k + 1) * self.u))
            rate.append(_next_quotient(radius, u, rate))
        return u, _integrated(rate, self.t)

    def series_in_u(self):
        """Taylor series of s and of the time around the present u."""
        speed = [self.u, mpf(1)] + [mpf(0)] * (ORDER - 2)
        s, p, g, force, slope, rate = [self.s], [], [], [], [], []
        drag = []
        for k in range(ORDER):
            p.append(_product(s, s, k))
            g.append(_product(p, p, k))
            drag.append(2 * (self.b * self.c_a * p[k] + self.c_h * g[k]))
            force.append(2 * (self.b * p[k] - g[k]) - _product(speed, drag, k))
            slope.append(_next_quotient(speed, force, slope))
            s.append(slope[k] / (k + 1))
            rate.append(_next_quotient([2 * c for c in s], force, rate))
        return s, _integrated(rate, self.t)

    def follow_s(self, direction):
        """Follow u(s) inwards until the path is steep (+1), or outwards to s = 0 (-1)."""
        while not (self.steep if direction > 0 else self.s == 0):
            u, time = self.series_in_s()
            h = direction * _step(u)
            if self.s + h < 0:
                h = -self.s
            self.s, self.u, self.t = self.s + h, _value(u, h), _value(time, h)
            if self.energy < 0:
                raise Captured

    def follow_u(self, direction, *, to_rest):
        """Follow s(u) to the turning point u = 0, or from it until the path is shallow."""
        while self.u != 0 if to_rest else (self.u == 0 or self.steep):
            s, time = self.series_in_u()
            h = _step(s)
            h = direction * (min(h, abs(self.u)) if to_rest else h)
            self.s, self.u, self.t = _value(s, h), self.u + h, _value(time, h)


def _shifted(polynomial, s):
    """Coefficients around s of a polynomial given from its highest coefficient."""
    terms = list(enumerate(reversed(polynomial)))
    return [
        mp.fdot((mp.binomial(n, k) * s ** (n - k), c) for n, c in terms[k:])
        for k in range(len(terms))
    ]


def _product(a, b, k):
    return mp.fdot((a[j], b[k - j]) for j in range(k + 1))


def _next_quotient(a, b, quotient):
    """Next coefficient of a/b."""
    k = len(quotient)
    return (a[k] - mp.fdot((b[j], quotient[k - j]) for j in range(1, k + 1))) / b[0]


def _integrated(rate, start):
    return [start, *(c / (k + 1) for k, c in enumerate(rate))]


def _step(series):
    """Step at which the last two terms fall to the tolerance."""
    scale = mpf(TOLERANCE) * abs(series[0])
    return min((scale / abs(series[k])) ** (mpf(1) / k) for k in (ORDER - 1, ORDER) if series[k])


def _value(series, h):
    return mp.polyval(series[::-1], h)


def impact(adhesion, w, c_h, c_a, damped_attachment):
    """Restitution, contact time and greatest compression; Captured where there is no rebound."""
    path = PhasePath(adhesion, c_h, c_a if damped_attachment else 0, w)
    path.follow_s(+1)
    path.follow_u(-1, to_rest=True)
    compression = path.s**2
    path.c_a = mpf(c_a)
    path.follow_u(-1, to_rest=False)
    path.follow_s(-1)
    return -path.u / mpf(w), path.t, compression


def capture_speed(c_h, c_a, damped_attachment):
    """Speed of the impact that leaves with ``LEAVING_SPEED``, the rest of it being negligible."""
    if c_h == 0 and c_a == 0:
        return mpf(0)
    path = PhasePath(1, c_h, c_a, "-" + LEAVING_SPEED)
    path.follow_s(+1)
    path.follow_u(+1, to_rest=True)
    path.c_a = mpf(c_a if damped_attachment else 0)
    path.follow_u(+1, to_rest=False)
    path.follow_s(-1)
    return path.u


def rows():
    """Every row of the table."""
    for adhesion, w, c_h, c_a, damped in IMPACTS:
        threshold = capture_speed(c_h, c_a, damped) if adhesion else mpf(0)
        yield _row(adhesion, w, c_h, c_a, damped, threshold)
    for c_h, c_a, damped, distances in THRESHOLDS:
        threshold = capture_speed(c_h, c_a, damped)
        for distance in distances:
            yield _row(1, float(threshold * (1 + mpf(distance))), c_h, c_a, damped, threshold)


def _row(adhesion, w, c_h, c_a, damped, threshold):
    numbers = (*impact(adhesion, w, c_h, c_a, damped), threshold)
    printed = [mp.nstr(number, PRINTED_DIGITS) for number in numbers]
    return [adhesion, w, c_h, c_a, int(damped), *printed]


if __name__ == "__main__":
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows())
