"""Files from which the AOMC program launches our photon counts.

degree_counts  Photon counts on whole degrees, the only directions that the AOMC program's sky file knows
folder         The folder of an export to the AOMC program: our sky beside copies of the scene's own files
refusals       Why the AOMC program cannot take a run: every reason at once, and the command that cures them
skydist        A skydist.inp from which the unmodified AOMC 1.2.2 program launches exactly our photon counts
values         Radiances from which the AOMC 1.2.2 program, in its 32-bit arithmetic, launches given integer counts
"""
