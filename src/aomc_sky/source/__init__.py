"""From a scene to photons: scene, plan, photon source, batches; and the files that describe a scene.

scene          A scene: wavebands, how many photons each gets, where they enter, what shines; and how it becomes a plan
plan/          The plan of a run: what every shard, export and check reads and never recomputes.
photon_source  The photon source: random access to every photon of a plan, without state
photons        A batch of photons: a struct of arrays, the area that it enters, and how a caller's arrays are reused
emitter        From a plan to arrays of photons: which kernel makes them, and the tables it reads
band_tables    Tables of one waveband in the form the emission kernels read
irradiance     Irradiance of a scene: in absolute units of each component, and planar over scalar of a band's photons
read/          The AOMC files and sky.toml become a scene.
light/         The light of a scene: which inputs of sky and sun win, and what they mean.
backgrounds/   Background-sky files become the light of a scene.
atmospheres/   An atmosphere description becomes a medium, and its sky directions.
host           A band's photons inside another code's own loop: jitted functions for numba, a C function for the rest
embedding      What a C or Fortran program asks of the Python that it started: a scene, then its bands
"""
