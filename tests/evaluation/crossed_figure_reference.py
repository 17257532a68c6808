#!/usr/bin/env python3
"""Prints the figures that crossed_figure_test.cpp expects, computed in another way: by NumPy, SciPy and statsmodels.

    crossed_figure_reference.py        needs numpy, scipy and statsmodels; statsmodels only for the mixed model

The variances of a complete design come from the mean squares of its analysis of variance, not from leaving anything out. Those of the
design with missing cells come from a jackknife that builds each smaller table by hand.
"""

import numpy as np
from scipy import stats

CONFIDENCE = 1 - 0.5 * 0.05  # of Student's t in an interval of 95 %

COMPLETE = np.array([  # [object][training][run]
    [[0.91, 0.94], [0.93, 0.97], [0.90, 0.92]],
    [[0.82, 0.85], [0.88, 0.86], [0.79, 0.80]],
    [[0.97, 0.99], [0.98, 0.96], [0.95, 0.99]],
    [[0.73, 0.78], [0.80, 0.84], [0.70, 0.75]],
])


def bounds(value, half, is_share):
    if not is_share:
        return value - half, value + half
    trials = value * (1 - value) * (stats.norm.ppf(0.975) / half) ** 2
    count = value * trials
    return stats.beta.ppf(0.025, count, trials - count + 1), stats.beta.ppf(0.975, count + 1, trials - count)


def mean_squares(table):
    """Of a table [unit][training]: the variances of its mean by unit, by training and by both."""
    units, trainings = table.shape
    of_unit, of_training, mean = table.mean(1), table.mean(0), table.mean()
    rest = table - of_unit[:, None] - of_training[None, :] + mean
    both = (rest**2).sum() / ((units - 1) * (trainings - 1))
    return of_unit.var(ddof=1) / units, of_training.var(ddof=1) / trainings, both / (units * trainings)


def half_width(by_unit, by_training, both, units, trainings):
    t = lambda freedom: stats.t.ppf((1 + CONFIDENCE) / 2, freedom)
    return np.sqrt(t(units - 1) ** 2 * by_unit + t(trainings - 1) ** 2 * max(0, by_training - both))


def by_jackknife(table):
    """The same variances from a table with gaps (NaN)."""
    value = lambda rows, columns: np.nanmean(table[np.ix_(rows, columns)])
    rows, columns = range(table.shape[0]), range(table.shape[1])
    but = lambda all_of, one: [i for i in all_of if i != one]
    by_row = np.array([value(but(rows, i), columns) for i in rows])
    by_column = np.array([value(rows, but(columns, j)) for j in columns])
    pairs = np.array([[value(but(rows, i), but(columns, j)) for j in columns] for i in rows])
    rest = pairs - pairs.mean(1)[:, None] - pairs.mean(0)[None, :] + pairs.mean()
    variance = lambda x: (len(x) - 1) * x.var()
    n, k = table.shape
    return variance(by_row), variance(by_column), (rest**2).sum() * (n - 1) * (k - 1) / (n * k)


def of_these_objects(tables):
    """Bounds of the mean over objects that stay, each a table [run][training]: runs are nested in objects, trainings are shared."""
    of_runs = np.array([mean_squares(table)[0] for table in tables]) / len(tables) ** 2
    both = sum(mean_squares(table)[2] for table in tables) / len(tables) ** 2
    by_training = np.mean([table.mean(0) for table in tables], axis=0).var(ddof=1) / tables[0].shape[1]
    freedom = int(of_runs.sum() ** 2 / sum(v**2 / (len(table) - 1) for v, table in zip(of_runs, tables)))
    half = half_width(of_runs.sum(), by_training, both, freedom + 1, tables[0].shape[1])
    return bounds(np.mean(tables), half, False)


def main():
    print("quantiles of t:", [round(stats.t.ppf((1 + c) / 2, d), 10) for d, c in ((1, 0.95), (2, 0.95), (3, 0.99), (9, 0.95), (30, 0.995), (2, CONFIDENCE))])

    table = COMPLETE.mean(2)
    by_object, by_training, both = mean_squares(table)
    print("complete, no limits:", bounds(table.mean(), half_width(by_object, by_training, both, 4, 3), False))

    one = COMPLETE[0].T  # [run][training] has two runs only; with those of the next object it has four
    one = np.vstack([one, COMPLETE[1].T])
    print("one object of four runs:", bounds(one.mean(), half_width(*mean_squares(one), 4, 3), False))

    gaps = one.copy()
    for training in range(3):
        gaps[training, training] = np.nan  # training k learned from run k
    print("with gaps, a share:", bounds(np.nanmean(gaps), half_width(*by_jackknife(gaps), 4, 3), True))
    for missed in ([1], [6], [1] * 6):
        shares = np.array(missed + [0] * (10 - len(missed))) / 52
        half = stats.t.ppf((1 + CONFIDENCE) / 2, 9) * shares.std(ddof=1) / np.sqrt(10)
        print("missed in ten objects of 52 each:", missed, bounds(shares.mean(), half, True))

    print("these objects:", of_these_objects([one, np.vstack([COMPLETE[2].T, COMPLETE[3].T])]))

    # Shares of the variance: runs are nested in objects.
    runs = COMPLETE.mean(1)
    of_runs = sum(x.var(ddof=1) / len(x) for x in runs) / len(runs) ** 2
    of_results = sum(mean_squares(object.T)[2] for object in COMPLETE) / len(COMPLETE) ** 2
    interaction = max(0, both - of_results)
    parts = np.array([max(0, by_training - both), max(0, by_object - of_runs - interaction), interaction, of_runs])
    print("shares of trainings, objects, both, runs:", parts / parts.sum())

    try:
        import pandas
        import statsmodels.formula.api as formula
    except ImportError:
        return
    frame = pandas.DataFrame(
        [(o, k, COMPLETE[o, k].mean()) for o in range(4) for k in range(3)], columns=["object", "training", "y"])
    frame["all"] = 1
    fit = formula.mixedlm("y ~ 1", frame, groups="all", vc_formula={"object": "0 + C(object)", "training": "0 + C(training)"}).fit()
    print("standard error of a mixed model (REML):", fit.bse["Intercept"], "and of the mean squares:", np.sqrt(by_object + by_training - both))


main()
