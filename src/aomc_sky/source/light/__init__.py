"""The light of a scene: inputs of sky and sun, and their meaning.

inputs          Inputs of the Perez sky and of the sun in order of precedence, and their shares of beam and sky
spectral_split  Beam and sky of each waveband from broadband irradiances, by spectra of SPCTRL2 and of clouds
plugin          The sky model of another package with its options
shares          Beam and sky of a scene as components in their shares
weather         Sun and sky from a time and a place, or from an hour of a weather file
sun_position    Position of the sun and its irradiance outside the atmosphere: pvlib's numbers in our conventions
"""
