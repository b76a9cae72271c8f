"""Rayleigh and Henyey-Greenstein samplers beside their alternatives: time and error in one run.

    python bench/phase.py [--draws 250000] [--repeats 25]

One thread. Inside numba every contender fills the same output from the same uniform numbers, turn and turn
about, and its least CPU time counts, since others may use the machine; then the public array functions beside the
same textbook forms in numpy. Errors are taken against
extended precision (Newton's method to the end; Henyey-Greenstein by the factored form), as the largest
absolute error of mu over uniform numbers, and as relative error of mu next to xi = 1/2. The bars: Rayleigh
at least 1.5 times as fast as Cardano's textbook form, Henyey-Greenstein no slower than the textbook's.
"""

from __future__ import annotations

import argparse

import numba
import numpy as np
from harness import best_cpu_time, machine, verdict

import aomc_sky as sky
from aomc_sky.phase import jitted

GAMMA = 0.01441  # air at 550 nm
G = 0.9
TABLE = 1024

njit = numba.njit(error_model="numpy")  # without a check of each division loops can become vectors: fair to all


@njit
def cardano(xi, gamma):
    """Textbook (Frisvad 2011): divides by 1 - gamma and subtracts two cube roots."""
    one = type(xi)(1)
    a = type(xi)(3) * (one + type(xi)(3) * gamma) / (one - gamma)
    b = type(xi)(4) * (one + (gamma + gamma)) / (one - gamma) * (one - (xi + xi))
    half = type(xi)(-0.5) * b
    root = np.sqrt(half * half + a * a * a / type(xi)(27))
    return np.cbrt(half + root) + np.cbrt(half - root)


@njit
def one_cube_root(xi, gamma):
    """The root without a difference, one cube root."""
    two = type(xi)(2)
    one = type(xi)(1)
    t = xi + xi - one
    A = one + type(xi)(3) * gamma
    C = two * (one + two * gamma)
    c = C * np.sqrt(one - gamma) * abs(t)
    w = np.cbrt(c + np.sqrt(c * c + A * A * A))
    q = A / w
    return two * C * t / (w * w + A + q * q)


@njit
def newton(xi, gamma):
    """Four steps of Newton's method from mu = t, enough for every gamma."""
    one, three = type(xi)(1), type(xi)(3)
    k = (one - gamma) / (three * (one + three * gamma))
    t = xi + xi - one
    y = (one + k) * t
    x = t
    for _ in range(4):
        x = x + (y - x * (one + k * x * x)) / (one + three * k * x * x)
    return x


def filler(sampler):
    """A loop over an array that calls a scalar sampler."""

    @njit
    def fill(xi, parameter, out):
        for k in range(xi.size):
            out[k] = sampler(xi[k], parameter)

    return fill


@njit
def table(xi, knots, out):
    """Linear interpolation in a table of the inverse."""
    n = knots.size - 1
    for k in range(xi.size):
        x = xi[k] * n
        j = min(int(x), n - 1)
        out[k] = knots[j] + (x - j) * (knots[j + 1] - knots[j])


@njit
def rejection(xi, gamma, out):
    """Uniform mu, accepted with p / max p; its own random numbers, since it needs a varying count of them."""
    s = (1 - gamma) / (1 + 3 * gamma)
    for k in range(out.size):
        while True:
            mu = 2 * np.random.random() - 1  # noqa: NPY002 - numba knows this one
            if np.random.random() * (1 + s) <= 1 + s * mu * mu:  # noqa: NPY002
                break
        out[k] = mu


@njit
def hg_textbook(xi, g):
    """Divides by g, and takes the difference of two numbers close to each other for small g."""
    one, two = type(xi)(1), type(xi)(2)
    f = (one - g * g) / (one - g + two * g * xi)
    return (one + g * g - f * f) / (two * g)


def cardano_numpy(xi, gamma):
    a = 3 * (1 + 3 * gamma) / (1 - gamma)
    half = -2 * (1 + 2 * gamma) / (1 - gamma) * (1 - 2 * xi)
    root = np.sqrt(half * half + a**3 / 27)
    return np.cbrt(half + root) + np.cbrt(half - root)


def hg_numpy(xi, g):
    f = (1 - g * g) / (1 - g + 2 * g * xi)
    return (1 + g * g - f * f) / (2 * g)


def true_rayleigh(xi, gamma):
    k = (1 - np.longdouble(gamma)) / (3 + 9 * np.longdouble(gamma))
    t = 2 * xi.astype(np.longdouble) - 1
    x = t
    for _ in range(12):
        x = ((1 + k) * t + 2 * k * x**3) / (1 + 3 * k * x * x)
    return x


def true_hg(xi, g):
    h, p = np.longdouble(g), xi.astype(np.longdouble)
    d = 1 - h
    v = 2 * d * d * (1 - p) * (1 + h * p) / (d + 2 * h * p) ** 2
    return np.where(v < 1, 1 - v, 2 * (1 + h) ** 2 * p * (d + h * p) / (d + 2 * h * p) ** 2 - 1)


def show(times: dict[str, float], n: int, base: str) -> None:
    for name, taken in times.items():
        print(f"  {name:34s} {1e9 * taken / n:7.2f} ns   {times[base] / taken:5.2f} x {base}")


def rayleigh_times(kind, n: int, repeats: int) -> dict[str, float]:
    xi, out, gamma = np.random.default_rng(1).random(n, dtype=kind), np.empty(n, dtype=kind), kind(GAMMA)
    knots = sky.rayleigh.sample_mu(np.linspace(0, 1, TABLE + 1), GAMMA).astype(kind)
    samplers = {"ours": jitted.rayleigh_sample_mu, "Cardano": cardano, "one cube root": one_cube_root, "Newton": newton}
    loops = {name: filler(sampler) for name, sampler in samplers.items()}
    work = {name: (lambda loop=loop: loop(xi, gamma, out)) for name, loop in loops.items()}
    work["table of 1024"] = lambda: table(xi, knots, out)
    work["rejection"] = lambda: rejection(xi, GAMMA, out)
    return best_cpu_time(work, repeats)


def hg_times(kind, n: int, repeats: int) -> dict[str, float]:
    xi, out, g = np.random.default_rng(1).random(n, dtype=kind), np.empty(n, dtype=kind), kind(G)
    ours, textbook = filler(jitted.hg_sample_mu), filler(hg_textbook)
    return best_cpu_time({"ours": lambda: ours(xi, g, out), "textbook": lambda: textbook(xi, g, out)}, repeats)


def array_times(n: int, repeats: int) -> dict[str, float]:
    xi = np.random.default_rng(1).random(n)
    return best_cpu_time(
        {
            "rayleigh.sample_mu": lambda: sky.rayleigh.sample_mu(xi, GAMMA),
            "Cardano in numpy": lambda: cardano_numpy(xi, GAMMA),
            "henyey_greenstein.sample_mu": lambda: sky.henyey_greenstein.sample_mu(xi, G),
            "textbook in numpy": lambda: hg_numpy(xi, G),
        },
        repeats,
    )


def rayleigh_errors(kind, gamma: float) -> None:
    gamma = kind(gamma)
    xi = np.random.default_rng(2).random(20_000, dtype=kind)
    beside = kind(0.5) + kind(np.finfo(kind).eps / 2) * np.arange(1, 100, dtype=kind)
    knots = sky.rayleigh.sample_mu(np.linspace(0, 1, TABLE + 1), gamma).astype(kind)
    for name in ("ours", "Cardano", "one cube root", "Newton", "table of 1024"):
        errors = []
        for place in (xi, beside):
            out = np.empty_like(place)
            if name.startswith("table"):
                table(place, knots, out)
            else:
                law = {"ours": jitted.rayleigh_sample_mu, "Cardano": cardano}
                law |= {"one cube root": one_cube_root, "Newton": newton}
                filler(law[name])(place, gamma, out)
            true = true_rayleigh(place, gamma)
            apart = np.abs(out - true)
            errors.append(float((apart if place is xi else apart / np.abs(true)).max()))
        print(f"  {kind.__name__}  1 - gamma = {1 - float(gamma):8.2g}  {name:14s} {errors[0]:9.1e} {errors[1]:9.1e}")


def hg_errors(kind, g: float) -> None:
    g = kind(g)
    xi = np.random.default_rng(2).random(20_000, dtype=kind)
    for name, law in (("ours", jitted.hg_sample_mu), ("textbook", hg_textbook)):
        out = np.empty_like(xi)
        filler(law)(xi, g, out)
        error = float(np.abs(out - true_hg(xi, g)).max())
        print(f"  {kind.__name__}  g = {float(g):10.6g}  {name:9s} {error:9.1e}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=250_000)
    parser.add_argument("--repeats", type=int, default=25)
    options = parser.parse_args()
    n, repeats = options.draws, options.repeats
    print(machine())
    bars = []
    for kind in (np.float64, np.float32):
        print(f"\nRayleigh, gamma {GAMMA}, inside numba, {kind.__name__}, time of one draw")
        times = rayleigh_times(kind, n, repeats)
        show(times, n, "Cardano")
        bars.append((f"Rayleigh {kind.__name__}: times Cardano's speed", times["Cardano"] / times["ours"], 1.5))
        print(f"\nHenyey-Greenstein, g {G}, inside numba, {kind.__name__}, time of one draw")
        times = hg_times(kind, n, repeats)
        show(times, n, "textbook")
        bars.append((f"HG {kind.__name__}: times the textbook's speed", times["textbook"] / times["ours"], 1.0))
    print("\narray functions, float64, time of one draw")
    times = array_times(n, repeats)
    show(times, n, "Cardano in numpy")
    bars.append(("rayleigh.sample_mu", times["Cardano in numpy"] / times["rayleigh.sample_mu"], 1.5))
    of_hg = times["textbook in numpy"] / times["henyey_greenstein.sample_mu"]
    bars.append(("henyey_greenstein.sample_mu", of_hg, 1.0))
    print("\nlargest error of mu: absolute over uniform numbers, relative next to xi = 1/2")
    for kind, gammas in ((np.float64, (0.0, 0.0144, 1 - 1e-10)), (np.float32, (0.0, 0.0144, 1 - 2.0**-24))):
        for gamma in gammas:
            rayleigh_errors(kind, gamma)
    print("\nlargest absolute error of mu, Henyey-Greenstein")
    for kind, sizes in ((np.float64, (1e-8, 1e-3, 0.9, 0.99999)), (np.float32, (1e-6, 1e-3, 0.9, 0.99999))):
        for g in sizes:
            hg_errors(kind, g)
    print()
    for name, found, bar in bars:
        print(f"{name:42s} {verdict(found, bar, at_least=True)}")


if __name__ == "__main__":
    main()
