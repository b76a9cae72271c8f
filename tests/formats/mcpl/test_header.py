"""What the head of an MCPL file says of our runs: read back as it was written, and nothing from what no run says."""

from dataclasses import replace

import pytest

from aomc_sky.formats.mcpl.header import McplHeader, McplRuns, plan_begin, runs_of

SHA256 = "fedcba9876543210" * 4
RUN = McplRuns(n_runs=1, n_photons=1000, n_iid=0, n_stratified=1000, seed=5, plan=plan_begin(SHA256))


def head(*comments):
    return McplHeader(n_particles=0, comments=comments)


@pytest.mark.parametrize("seed", [0, 1, 2**32 - 1, 2**32, 2**53 + 1, 2**64 - 1])
@pytest.mark.parametrize("sha256", [SHA256, "0" * 64, "f" * 64])
def test_a_run_is_read_back_to_the_last_bit(seed, sha256):
    run = replace(RUN, seed=seed, plan=plan_begin(sha256))
    assert runs_of(head("made by", *run.comments(), "another comment")) == run
    assert run.is_plan(sha256)
    assert not run.is_plan("e" + sha256[1:])


def test_sums_of_several_runs_have_no_seed_and_no_plan():
    comments = [c.replace("sky_runs:" + " " * 23 + "1", "sky_runs:" + " " * 23 + "2") for c in RUN.comments()]
    runs = runs_of(head(*comments))
    assert (runs.n_runs, runs.seed, runs.plan) == (2, None, "")
    assert not runs.is_plan(SHA256)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda c: c[:-1],  # no plan
        lambda c: [x for x in c if "seed_low" not in x],
        lambda c: [x.replace("sky_runs:" + " " * 23 + "1", "sky_runs:" + " " * 22 + "-1") for x in c],  # not known
        lambda c: [x.replace("sky_runs:" + " " * 23 + "1", "sky_runs:" + " " * 23 + "0") for x in c],
        lambda c: [x.replace("1000", " 0.5") for x in c],
        lambda c: [x.replace("1000", "1e99999") for x in c],
        lambda c: [x.replace("1000", " nan") for x in c],
        lambda c: [x.replace("1000", "many") for x in c],
        lambda c: [x.replace("photons:                    1000", "photons:                       1") for x in c],
    ],
)
def test_what_no_run_says_is_of_unknown_origin(spoil):
    comments = RUN.comments()
    assert runs_of(head(*comments)) is not None
    spoilt = spoil(list(comments))
    assert spoilt != list(comments)
    assert runs_of(head(*spoilt)) is None
