"""The files of a run folder against its plan.

blocks      Blocks of photons against their leaves and against the plan: which block is damaged, and what is wrong ...
counts      The counts of a plan against its masses
files       The files of a run against its manifest: there, of the right length, of the right SHA-256
manifest    The manifest of a run or shard against everything that the plan and the files determine
open_parts  From a run folder to the parts that are verified
parts       The parts of a run folder that can be verified: the whole run, or its shards while they are not merged
photons     The photons of one waveband of a run as its files hold them: every block compared while it is read
rebuilt     What a plan alone makes again, and what nobody can say without the scene
run         A finished run, or its shards, verified: files, counts, blocks, directions
scene_plan  A run against the scene that it says it came from: the plan made again from the scene's files
"""
