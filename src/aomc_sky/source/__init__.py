"""From a scene to photons: scene, plan, photon source, batches; and the AOMC files that describe a scene."""
