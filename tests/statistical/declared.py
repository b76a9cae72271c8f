"""Every statistical test of this folder: file -> test -> (cases, p-values per case)."""

from tests.support.plan import StatisticalPlan

DECLARED = {
    "test_cells": {"test_place_in_the_cell": (20, 3), "test_digits_below_the_24th": (1, 2)},
    "test_disc": {"test_disc": (8, 1)},
    "test_skies": {"test_independent_photons": (2, 1), "test_means": (2, 2)},
    "test_function_sky": {
        "test_a_bright_zenith": (1, 1),
        "test_a_spot_of_one_degree": (1, 1),
        "test_a_jump_at_an_azimuth": (1, 1),
        "test_photons_follow_the_function_inside_coarse_patches": (1, 1),
        "test_a_function_of_wavelength": (2, 1),
    },
    "test_cie_sky": {"test_photons_of_general_skies": (2, 1)},
    "test_low_discrepancy": {"test_over_seeds_each_photon_is_uniform": (2, 4), "test_pairs_of_patches": (1, 2)},
    "test_numbers": {
        "test_over_seeds_they_are_uniform": (2, 12),
        "test_philox_placement_makes_them_independent": (1, 12),
    },
    "test_counts": {"test_rounding_is_bernoulli": (1, 12), "test_multinomial_is_multinomial": (1, 1)},
    "test_replicates": {
        "test_the_exact_mean_lies_within_the_error_bars": (2, 2),
        "test_error_bars_of_the_mean_of_1_over_mu": (2, 2),
        "test_photons_of_any_number_of_replicates_have_the_exact_mean": (3, 1),
        "test_replicates_do_not_know_each_other": (1, 3),
        "test_independent_photons_in_every_replicate": (1, 2),
    },
    "test_order": {"test_prefixes": (1, 3), "test_neighbours": (1, 1)},
    "test_footprints": {"test_positions": (4, 3), "test_positions_do_not_know_directions": (2, 1)},
    "test_streams": {"test_streams_are_apart": (3, 1), "test_methods_of_one_seed_are_apart": (4, 1)},
    "test_internal_source": {"test_diffuse_light": (3, 4), "test_direct_share": (1, 1), "test_circle": (1, 2)},
    "test_phase": {"test_rayleigh": (8, 2), "test_henyey_greenstein": (12, 3), "test_small_g": (1, 1)},
    "test_perez_emission": {
        "test_independent_photons": (3, 6),
        "test_any_grid": (4, 2),
        "test_states_of_all_clearness_bins": (72, 2),
        "test_clipped_skies": (2, 2),
        "test_stratified_photons": (3, 1),
    },
    "test_lobes": {"test_patches": (12, 2), "test_single_precision": (2, 1)},
    "test_lobe_emission": {
        "test_patches": (12, 1),
        "test_even_photons": (1, 2),
        "test_needle_keeps_its_digits": (2, 1),
        "test_the_simple_sampler_is_right": (1, 1),
    },
    "test_lobe_fairness": {
        "test_bins_get_their_expectation": (4, 1),
        "test_one_photon_over_seeds_follows_the_law": (2, 1),
    },
    "test_verify": {
        "test_chi_squares_of_independent_photons": (2, 5),
        "test_chi_squares_after_thinning": (1, 3),
        "test_chi_squares_of_weights": (1, 3),
        "test_kolmogorov_distances": (1, 1),
        "test_shares_uniform_in_zenith_angle": (1, 1),
        "test_shares_of_lambert": (1, 1),
        "test_thinning_is_fair": (1, 2),
    },
}

PLAN = StatisticalPlan(
    declared={
        f"{stem}::{name}": cases * p_values
        for stem, tests in DECLARED.items()
        for name, (cases, p_values) in tests.items()
    }
)
