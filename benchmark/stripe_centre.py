# SPDX-FileCopyrightText: 2026 active_handeye contributors
# SPDX-License-Identifier: Apache-2.0
"""detectStripe: error of the centre against its Cramer-Rao bound, and time against cv2.GaussianBlur.

Gaussian stripes of known centre, a little oblique, 8 bit. Bound of one column: noise / height * sqrt(2 sigma /
sqrt(pi)), with sigma, height and offset of the stripe unknown or not; under grain that of `grain_bound`. Time: one
thread, processor time, calls take turns, the fastest of many counts. A Steger detector (second derivatives of a
Gaussian by scipy.ndimage, the zero of the first derivative across the line) is what is used otherwise; copying the
frame is what no detector can beat.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

import cv_active_handeye as cah

from .report import Cell, Measure, Report, Table, finish, parser
from .scene import Array
from .speed import fastest

Grey = NDArray[np.uint8]
SIGMAS, PEAK_SNRS = (1.0, 1.5, 2.5, 4.0), (5.0, 7.0, 10.0, 20.0, 50.0)
NOISE, ROUNDING, OFFSET = 3.0, 1 / 12, 30.0
SPECKLE, GRAIN_PX = 0.06, 0.7
"""Relative contrast of the laser's grain, as in the simulated cell, and the Gaussian it is smoothed by."""
HEIGHT, BRIGHT, SATURATED = 120.0, 900.0, 0.05
HONEST_FROM, MAX_DISHONEST = 7.0, 0.05
FRAME, HEIGHTS = (1920, 1200), (150, 300, 600, 1200)
MAX_RATIO, MAX_BIAS, MAX_SPOILED, MAX_TIME, MIN_GAIN, MAX_SLOPE = 1.15, 0.01, 0.1, 0.5, 20.0, 1.1


class Accuracy(NamedTuple):
    """Errors of the columns of some images, px; `honest`: RMS of the errors in units of the stated deviations."""

    sigma: float
    snr: float
    share: float
    rmse: float
    ratio: float
    bias: float
    honest: float


class Spoiled(NamedTuple):
    """Errors under grain and saturation, px; bound: smallest RMS that an unbiased estimate of one column can have."""

    sigma: float
    share: float
    rms: float
    bound: float
    largest: float


def stripe_image(
    rng: np.random.Generator,
    sigma: float,
    height: float | Array,
    size: tuple[int, int] = (1920, 240),
    speckle: float = 0.0,
) -> tuple[Grey, Array]:
    """Image and the row of the centre in every column."""
    columns, rows = size
    centre = 0.5 * rows + rng.uniform(-0.5, 0.5) + rng.uniform(-0.02, 0.02) * np.arange(columns)
    light = height * np.exp(-0.5 * ((np.arange(rows)[:, None] - centre) / sigma) ** 2)
    if speckle:
        grain = ndimage.gaussian_filter(rng.normal(size=light.shape), GRAIN_PX)
        light *= np.maximum(0, 1 + speckle * grain / grain.std())
    grey = OFFSET + light + rng.normal(0, NOISE, light.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8), np.asarray(centre, np.float64)


def params(sigma: float) -> cah.StripeParams:
    """Those of a stripe of this width."""
    made = cah.StripeParams()
    made.sigma = sigma
    return made


def errors(image: Grey, centre: Array, sigma: float) -> tuple[Array, Array]:
    """Errors of the columns found, and their stated standard deviations, px."""
    points, sigmas = cah.detectStripe(image, params=params(sigma))
    return points[:, 1] - centre[points[:, 0].astype(int)], sigmas.ravel()


def accuracy(seed: int, images: int) -> tuple[Table, list[Measure]]:
    """RMSE and bias for every width and height of the stripe."""
    rows: list[Accuracy] = []
    for sigma in SIGMAS:
        for snr in PEAK_SNRS:
            noise = np.hypot(NOISE, np.sqrt(ROUNDING))
            rng = np.random.default_rng([seed, round(10 * sigma), round(snr)])
            found = [errors(*stripe_image(rng, sigma, snr * noise), sigma) for _ in range(images)]
            error, stated = (np.concatenate(part) for part in zip(*found, strict=True))
            bound = np.sqrt(2 * sigma / np.sqrt(np.pi)) / snr
            rmse = float(np.sqrt(np.mean(error**2)))
            honest = float(np.sqrt(np.mean((error / stated) ** 2)))
            share = 100 * len(error) / (1920 * images)
            rows.append(Accuracy(sigma, snr, share, rmse, rmse / bound, float(np.mean(error)), honest))
    columns = ("sigma [px]", "peak / noise", "columns found [%]", "RMSE [px]", "/ bound", "bias [px]", "error / stated")
    return Table("Centre of a Gaussian stripe", columns, rows), [
        Measure("stripe centre: RMSE / bound, largest", max(row.ratio for row in rows), MAX_RATIO),
        Measure("stripe centre: bias [px], largest", max(abs(row.bias) for row in rows), MAX_BIAS),
        Measure(
            f"stripe centre: stated deviations off by, peak / noise >= {HONEST_FROM:g}",
            max(abs(row.honest - 1) for row in rows if row.snr >= HONEST_FROM),
            MAX_DISHONEST,
        ),
    ]


def grain_bound(sigma: float, height: float) -> float:
    """Cramer-Rao bound of one column's centre, px, mean over its place in the pixel: Gaussian noise and grain of known
    covariance, height and offset unknown, pixels that saturate not seen."""
    variances = []
    for centre in np.linspace(-0.5, 0.5, 8, endpoint=False):
        y = np.arange(-np.ceil(6 * sigma), np.ceil(6 * sigma) + 1)
        profile = np.exp(-0.5 * ((y - centre) / sigma) ** 2)
        seen = OFFSET + height * profile < 255
        y, profile = y[seen], profile[seen]
        slope = height * profile * (y - centre) / sigma**2
        J = np.column_stack([slope, profile, np.ones_like(y)])
        grain = (SPECKLE * height) ** 2 * np.exp(-0.25 * (np.subtract.outer(y, y) / GRAIN_PX) ** 2)
        C = (NOISE**2 + ROUNDING) * np.eye(len(y)) + grain * np.outer(profile, profile)
        dC = grain * (np.outer(slope, profile) + np.outer(profile, slope)) / height
        inverse = np.linalg.inv(C)
        schur = 1 / np.linalg.inv(J.T @ inverse @ J)[0, 0]
        variances.append(1 / (schur + 0.5 * float(np.trace(inverse @ dC @ inverse @ dC))))
    return float(np.sqrt(np.mean(variances)))


def spoiled(seed: int, images: int) -> tuple[Table, list[Measure]]:
    """Grain of the laser's light, and columns so bright that they saturate; with the bound that the grain sets."""
    rows: list[Spoiled] = []
    for sigma in SIGMAS:
        rng = np.random.default_rng([seed, round(10 * sigma)])
        found = []
        for _ in range(images):
            height = np.where(rng.random(1920) < SATURATED, BRIGHT, HEIGHT)
            image, centre = stripe_image(rng, sigma, height, speckle=SPECKLE)
            found.append(errors(image, centre, sigma)[0])
        error = np.concatenate(found)
        share = 100 * len(error) / (1920 * images)
        variances = [grain_bound(sigma, peak) ** 2 for peak in (HEIGHT, BRIGHT)]
        bound = float(np.sqrt(np.average(variances, weights=[1 - SATURATED, SATURATED])))
        rms = float(np.sqrt(np.mean(error**2)))
        rows.append(Spoiled(sigma, share, rms, bound, float(np.abs(error).max())))
    title = f"{100 * SATURATED:g} % of the columns saturated, speckle with a contrast of {100 * SPECKLE:g} %"
    table = Table(title, ("sigma [px]", "columns found [%]", "RMS [px]", "bound [px]", "largest [px]"), rows)
    worst = max(row.rms for row in rows)
    return table, [Measure("saturated columns and speckle: RMS [px], largest", worst, MAX_SPOILED)]


def steger(image: Grey, sigma: float) -> Array:
    """Centre line of ridges: the strongest point of every column, (M, 2) px."""
    grey = image.astype(np.float32)
    x, y = (ndimage.gaussian_filter(grey, sigma, order) for order in ((0, 1), (1, 0)))
    xx, xy, yy = (ndimage.gaussian_filter(grey, sigma, order) for order in ((0, 2), (1, 1), (2, 0)))
    root = np.hypot(xx - yy, 2 * xy)
    strength = 0.5 * (xx + yy - root)
    angle = 0.5 * np.arctan2(2 * xy, xx - yy) + 0.5 * np.pi
    nx, ny = np.cos(angle), np.sin(angle)
    t = -(x * nx + y * ny) / (xx * nx**2 + 2 * xy * nx * ny + yy * ny**2)
    on_line = (np.abs(t * nx) <= 0.5) & (np.abs(t * ny) <= 0.5)
    row = np.argmin(np.where(on_line, strength, 0), axis=0)
    column = np.arange(image.shape[1])
    at = (row, column)
    return np.column_stack([column + t[at] * nx[at], row + t[at] * ny[at]])


def speed(seed: int, rounds: int) -> tuple[list[Table], list[Measure]]:
    """Against a blur, a Steger detector and a copy of the same frame; and with growing frames."""
    rng = np.random.default_rng(seed)
    sigma = 1.5
    image, _ = stripe_image(rng, sigma, 150.0, FRAME)
    blurred, copied, standard = np.empty_like(image), np.empty_like(image), params(sigma)
    calls = (
        lambda: cah.detectStripe(image, params=standard),
        lambda: cv2.GaussianBlur(image, (5, 5), 0, blurred),
        lambda: np.copyto(copied, image),
    )
    ours, blur, copy = fastest(calls, rounds)
    (line,) = fastest([lambda: steger(image, sigma)], 3, 1)
    names = ("detectStripe", f"cv2.GaussianBlur 5 x 5 ({cv2.__version__})", "copy", "Steger, scipy.ndimage")
    rows: list[list[Cell]] = [
        [name, 1e3 * seconds, seconds / blur, 1e-9 * image.size / seconds]
        for name, seconds in zip(names, (ours, blur, copy, line), strict=True)
    ]
    table = Table(f"{FRAME[0]} x {FRAME[1]}, 8 bit", ("call", "time [ms]", "/ blur", "gigapixel / s"), rows)
    frames = [stripe_image(rng, sigma, 150.0, (FRAME[0], height))[0] for height in HEIGHTS]
    times = fastest([partial(cah.detectStripe, frame, params=standard) for frame in frames], rounds)
    growth: list[list[Cell]] = [[height, 1e3 * t] for height, t in zip(HEIGHTS, times, strict=True)]
    slope = float(np.log(times[-1] / times[0]) / np.log(HEIGHTS[-1] / HEIGHTS[0]))
    return [table, Table(f"{FRAME[0]} columns", ("rows", "time [ms]"), growth)], [
        Measure("detectStripe / GaussianBlur 5 x 5: time", ours / blur, MAX_TIME),
        Measure("Steger detector / detectStripe: time", line / ours, MIN_GAIN, at_least=True),
        Measure("detectStripe: growth with rows, slope", slope, MAX_SLOPE),
    ]


def measure(seed: int = 1, images: int = 10, rounds: int = 100) -> Report:
    """Accuracy and speed."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    tables, limits = speed(seed, rounds)
    cv2.setNumThreads(threads)
    for table, more in (accuracy(seed, images), spoiled(seed, images)):
        tables.append(table)
        limits += more
    setup = (
        f"Seed {seed}; {images} images of 1920 columns each, {NOISE:g} grey levels of noise; columns without a clear "
        f"peak are left out by the detector. One thread, processor time, fastest of {rounds} rounds."
    )
    return Report("Stripe detection", setup, tables, limits)


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    line = parser(__doc__ or "")
    line.add_argument("--seed", type=int, default=1, help="seed of stripes and noise")
    line.add_argument("--images", type=int, default=10, help="images of every kind (default 10)")
    line.add_argument("--rounds", type=int, default=100, help="rounds of timing (default 100)")
    options = line.parse_args(arguments)
    return finish(measure(options.seed, options.images, options.rounds), options.output)


if __name__ == "__main__":
    sys.exit(main())
