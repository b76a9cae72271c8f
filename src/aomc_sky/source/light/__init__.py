"""The light of a scene: what is said about sun and sky, and the components that it becomes.

inputs          `LightInputs`: what a caller, sky.toml and amc.inp say, which of them wins, and when it is used
light           `light_of`: inputs, a sky and backgrounds become components with strengths and irradiances
diffuse         Diffuse skies beside which the sun's beam is launched
sun             The sun of a scene, and how bright sun and sky are by irradiances, or by clearness and brightness
spectral_split  Beam and sky of each waveband by SPCTRL2: a cloudless sky, or spectra scaled to dni and dhi
weather         Sun and sky from a time and a place, or from an hour of a weather file
sun_position    Position of the sun and its irradiance outside the atmosphere: pvlib's numbers in our conventions
plugin          The sky model of another package with its options
"""
