"""The light of a scene in three questions: where is the sun, how bright are beam and sky in each waveband, which sky?

said            What one speaker says, checked: a caller, a weather file, sky.toml, the files of AOMC; who comes first
place           Where is the sun? The angles that the first one says
brightness      How bright? One answer of a small set, each with `in_bands(sun, wavelength_nm, own)`
skies           Which sky? The protocol `Sky`, and those that are no files
join            `light_of`: the answers become components with strengths and irradiances
unused          What is not used: of a caller an error, of a file a note
spectral_split  Beam and sky of each waveband by SPCTRL2: a cloudless sky, or spectra scaled to dni and dhi
weather         The sun, and irradiances, of a time and a place or of an hour of a weather file
sun_position    Position of the sun and its irradiance outside the atmosphere: pvlib's numbers in our conventions
plugin          The sky model of another package with its options
"""
