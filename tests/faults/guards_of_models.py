"""Guards of rows 34 to 36: the Perez sky at the edges of its inputs, and lobes."""

from __future__ import annotations

from tests.support.guards import Guard

CLEARNESS = "skies/perez/coefficients.py"
COEFFICIENTS = "skies/perez/coefficients.py"
SKY = "skies/perez/sky.py"
COMMAND = "cli/commands/perez.py"
KEYS = "formats/sky_toml/keys.py"
LOBE_FILE = "formats/background/file.py"

EDGE_GUARDS = (
    Guard(
        row=34,
        file=CLEARNESS,
        text='return np.searchsorted(np.array(EPSILON_EDGES[1:]), clearness, side="right")',
        without='return np.searchsorted(np.array(EPSILON_EDGES[1:]), clearness, side="left")',
        test="test_perez_faults.py::test_edges_of_the_inputs[row-34-epsilon-on-the-first-edge]",
    ),
    Guard(
        row=34,
        file=COEFFICIENTS,
        text="clearness = np.clip(clearness, *EPSILON_LIMITS)",
        without="",
        test="test_perez_faults.py::test_edges_of_the_inputs[row-34-epsilon-above-12]",
    ),
    Guard(
        row=34,
        file=COEFFICIENTS,
        text="brightness = np.clip(brightness, *DELTA_LIMITS)",
        without="",
        test="test_perez_faults.py::test_edges_of_the_inputs[row-34-delta-above-its-range]",
    ),
    Guard(
        row=34,
        file=COEFFICIENTS,
        text="return clearness, np.maximum(brightness, floor)",
        without="return clearness, brightness",
        test="test_perez_faults.py::test_edges_of_the_inputs[row-34-delta-below-the-floor-of-rows-2-to-5]",
    ),
    Guard(
        row=34,
        file=SKY,
        text="if used_delta != delta and not (by_weather and delta == 0):",
        without="if False:",
        test="test_perez_faults.py::test_edges_of_the_inputs[row-34-delta-0]",
    ),
)
NO_SUBSTITUTE_GUARDS = (
    Guard(
        row=34,
        file=COMMAND,
        text="if not 0 <= arguments.sun_zenith < 90:",
        without="if False:",
        test="test_perez_faults.py::test_no_substitute_sky[row-34-sun-on-the-horizon]",
    ),
    Guard(
        row=34,
        file=COMMAND,
        text='if dhi == 0:\n        raise SceneError("the diffuse irradiance',
        without='if False:\n        raise SceneError("the diffuse irradiance',
        test="test_perez_faults.py::test_no_substitute_sky[row-34-no-diffuse-light]",
    ),
    Guard(
        row=34,
        file="source/light/inputs.py",
        text="if diffuse == 0:",
        without="if False:",
        test="test_perez_faults.py::test_no_substitute_sky_in_a_run[row-34-no-diffuse-light-in-a-run]",
    ),
    Guard(
        row=34,
        file="source/light/inputs.py",
        text='if sun.zenith_deg >= 90.0 and sun.origin != "amc.inp":',
        without="if False:",
        test="test_perez_faults.py::test_no_substitute_sky_in_a_run[row-34-sun-below-the-horizon-in-a-run]",
    ),
    Guard(
        row=34,
        file=KEYS,
        text="_IRRADIANCE = Range(low=0, high=10_000)",
        without="_IRRADIANCE = Range(low=-5, high=10_000)",
        test="test_perez_faults.py::test_no_substitute_sky[row-34-negative-diffuse-light]",
    ),
    Guard(
        row=34,
        file=KEYS,
        text='"epsilon": Range(low=1),',
        without='"epsilon": Range(low=0),',
        test="test_perez_faults.py::test_no_substitute_sky[row-34-epsilon-below-1]",
    ),
    Guard(
        row=34,
        file=KEYS,
        text='"delta": Range(low=0),',
        without='"delta": Range(low=-1),',
        test="test_perez_faults.py::test_no_substitute_sky[row-34-delta-negative]",
    ),
)
LUMINANCE_GUARDS = (
    Guard(
        row=35,
        file=SKY,
        text='            self._warn(f"the luminance is negative over',
        without='            str(f"the luminance is negative over',
        test="test_perez_faults.py::test_negative_luminance[row-35-negative-luminance-counts-as-0]",
    ),
    Guard(
        row=35,
        file="kernels/perez/plain_mass.py",
        text="line += np.maximum(factor[:, None] * second_factor(h, sky[2], sky[3], sky[4]), 0.0)",
        without="line += factor[:, None] * second_factor(h, sky[2], sky[3], sky[4])",
        test="test_perez_faults.py::test_negative_luminance[row-35-negative-luminance-counts-as-0]",
        hangs=True,
    ),
    Guard(
        row=35,
        file=SKY,
        text="if share >= 1 or self.relative_integral <= 0:",
        without="if False:",
        test="test_perez_faults.py::test_a_sky_that_is_nowhere_positive[row-35-nowhere-positive]",
    ),
    Guard(
        row=35,
        file=SKY,
        text='self._warn(f"b = {values[1]',
        without='str(f"b = {values[1]',
        test="test_perez_faults.py::test_an_infinite_horizon[row-35-b-above-0]",
    ),
    Guard(
        row=35,
        file=SKY,
        text="if values[1] > 0:",
        without="if False:",
        test="test_perez_faults.py::test_an_infinite_horizon[row-35-b-above-0]",
        hangs=True,
    ),
    Guard(
        row=35,
        file="skies/perez/functions.py",
        text="where=np.broadcast_to(mu > 0, shape)",
        without="where=True",
        test="test_perez_faults.py::test_the_horizon_itself[row-35-cosine-0-at-the-horizon]",
    ),
)
LOBE_GUARDS = (
    Guard(
        row=36,
        file="skies/lobes/lobe.py",
        text="np.where(z > 0.0, side / (length * (length + z)), (length - z) / length)",
        without="(length - z) / length",
        test="test_lobe_faults.py::test_needles_keep_their_density_and_mass[row-36-g-next-to-1]",
    ),
    Guard(
        row=36,
        file=LOBE_FILE,
        text="(keys.param0 >= 0.0) & (keys.param0 < 1.0)",
        without="(keys.param0 >= 0.0)",
        test="test_lobe_faults.py::test_parameters_outside[row-36-g-1]",
    ),
    Guard(
        row=36,
        file=LOBE_FILE,
        text="(keys.param0 >= 0.0) & (keys.param0 < 1.0)",
        without="(keys.param0 < 1.0)",
        test="test_lobe_faults.py::test_parameters_outside[row-36-g-negative]",
    ),
    Guard(
        row=36,
        file=LOBE_FILE,
        text="(np.isfinite(values) & (values > 0.0))",
        without="(np.isfinite(values) & (values >= 0.0))",
        test="test_lobe_faults.py::test_parameters_outside[row-36-alpha-0]",
    ),
    Guard(
        row=36,
        file=LOBE_FILE,
        text="bad = ~(np.abs(length - 1.0) < 1e-6)",
        without="bad = np.abs(length - 1.0) > 1e-6",
        test="test_lobe_faults.py::test_parameters_outside[row-36-rotation-nan]",
    ),
    Guard(
        row=36,
        file="skies/lobes/lobe.py",
        text="return np.ldexp(q, -np.frexp(largest)[1])",
        without="return q",
        test="test_lobe_faults.py::test_a_quaternion_of_any_length[row-36-rotation-not-of-length-1]",
    ),
    Guard(
        row=36,
        file="skies/lobes/animation.py",
        text="low = np.clip(after - 1, 0, last)",
        without="low = after - 1",
        test="test_lobe_faults.py::test_a_time_outside_the_keys[row-36-time-outside-the-keys]",
    ),
    Guard(
        row=36,
        file="formats/sky_toml/rules.py",
        text='if moment is None:\n            return [Fault("E703"',
        without='if False:\n            return [Fault("E703"',
        test="test_lobe_faults.py::test_a_time_that_is_none[row-36-time-nan]",
    ),
    Guard(
        row=36,
        file="formats/sky_toml/rules.py",
        text="if moment.utcoffset() is None:",
        without="if False:",
        test="test_lobe_faults.py::test_a_time_that_is_none[row-36-time-without-zone]",
    ),
)
MODEL_GUARDS = (*EDGE_GUARDS, *NO_SUBSTITUTE_GUARDS, *LUMINANCE_GUARDS, *LOBE_GUARDS)
