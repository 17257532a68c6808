#!/usr/bin/env python3
"""Differences between two settings of a model, each trained several times, from the results of `tactile eval --json`.

  benchmarks/compare_models.py USUAL-1.json OTHER-1.json USUAL-2.json OTHER-2.json …

Two neighbours are trainings of the two settings on the same run and seed. Accuracy and delay of each training and object are paired;
their 95 % intervals are those of two crossed random effects (Satterthwaite's degrees of freedom). Counts of false alarms are paired by
training. Needs scipy.
"""
import json
import math
import statistics
import sys

from scipy.stats import t


def two_way_interval(values):
    """Mean and 95 % interval of values[training][object]; both are drawn at random."""
    trainings, objects = len(values), len(values[0])
    n = trainings * objects
    mean = sum(map(sum, values)) / n
    of_training = [statistics.mean(row) for row in values]
    of_object = [statistics.mean(column) for column in zip(*values)]
    squares = {
        "training": objects * sum((x - mean) ** 2 for x in of_training) / (trainings - 1),
        "object": trainings * sum((x - mean) ** 2 for x in of_object) / (objects - 1),
        "rest": sum((values[k][o] - of_training[k] - of_object[o] + mean) ** 2 for k in range(trainings) for o in range(objects))
        / ((trainings - 1) * (objects - 1)),
    }
    degrees = {"training": trainings - 1, "object": objects - 1, "rest": (trainings - 1) * (objects - 1)}
    # Below the larger of the two, the difference of mean squares is chance.
    variance = max(squares["training"] + squares["object"] - squares["rest"], squares["training"], squares["object"])
    freedom = variance**2 / sum(squares[name] ** 2 / degrees[name] for name in squares)
    half = t.ppf(0.975, freedom) * math.sqrt(variance / n)
    return mean, mean - half, mean + half


def one_way_interval(values):
    mean = statistics.mean(values)
    half = t.ppf(0.975, len(values) - 1) * statistics.stdev(values) / math.sqrt(len(values))
    return mean, mean - half, mean + half


def main():
    evaluations = []
    for path in sys.argv[1:]:
        with open(path) as file:
            evaluations.append(json.load(file))
    usual, other = evaluations[::2], evaluations[1::2]
    names = sorted(set.intersection(*(set(one["accuracy"]["objects"]) for one in evaluations)))

    def differences(value):
        return [[value(b, name) - value(a, name) for name in names] for a, b in zip(usual, other)]

    def print_row(what, a, b, interval, unit):
        print(f"{what}: {a:.2f} and {b:.2f} {unit}, difference {interval[0]:+.2f} [{interval[1]:+.2f}, {interval[2]:+.2f}]")

    accuracy = differences(lambda one, name: 100 * one["accuracy"]["objects"][name]["value"])
    means = [statistics.mean(100 * one["accuracy"]["mean"]["value"] for one in group) for group in (usual, other)]
    print(f"{len(usual)} trainings, {len(names)} objects")
    print_row("accuracy", *means, two_way_interval(accuracy), "%")
    # Of whole runs; a touch that is not detected is later than all others.
    delays = differences(lambda one, name: one["whole_runs"]["objects"][name]["median_ms"]["value"])
    medians = [statistics.mean(one["whole_runs"]["decided"]["median_ms"]["value"] for one in group) for group in (usual, other)]
    print_row("median delay", *medians, two_way_interval(delays), "ms")
    for key, what in (("missed", "share missed or early"), ("wrong_class", "episodes of the wrong class per touch")):
        shares = [statistics.mean(one["whole_runs"]["decided"][key]["value"] for one in group) for group in (usual, other)]
        print(f"{what}: {shares[0]:.4f} and {shares[1]:.4f}")
    alarms = lambda one: one["whole_runs"]["decided"]["alarms_per_min"]["value"]
    per_min = [statistics.mean(map(alarms, group)) for group in (usual, other)]
    ratio = one_way_interval([math.log(alarms(b) / alarms(a)) for a, b in zip(usual, other)])
    print(f"false alarms per minute: {per_min[0]:.1f} and {per_min[1]:.1f}, ratio " + "{:.2f} [{:.2f}, {:.2f}]".format(*map(math.exp, ratio)))


if __name__ == "__main__":
    main()
