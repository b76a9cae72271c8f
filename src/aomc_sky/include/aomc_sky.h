/* The photons of aomc-sky in a program written in C, C++ or Fortran.
 *
 * A band's photons come from one function and its context: PhotonSource.c_source(band) in Python, or
 * aomc_sky_band() below, where the program starts Python itself (aomc_sky_embed.c, only for that).
 * The function needs no lock and no Python; any number of threads may call it at once. Photon i of a band
 * is the same whoever asks for it, so parallel programs simply take disjoint ranges.
 *
 * Bands and photons are counted from 0. Directions are unit vectors of travel, z up: uz <= 0.
 */
#ifndef AOMC_SKY_H
#define AOMC_SKY_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Answers of `next` and `numbers` that are no number of photons. */
enum {
    AOMC_SKY_CLOSED = -1,    /* the context is NULL, or its source was closed or dropped */
    AOMC_SKY_BAD_START = -2, /* start < 0 */
    AOMC_SKY_BAD_COUNT = -3, /* n < 0 */
    AOMC_SKY_NO_ARRAY = -4   /* a pointer to the directions is NULL, or all three to the numbers are */
};

/* Write the directions of the photons [start, start + n) and return how many were written: fewer at the end
 * of the band, 0 from there on, and a negative number for the errors above, when nothing is written. The arrays
 * have at least n entries each and do not overlap. */
typedef int64_t (*aomc_sky_next)(void *context, int64_t start, int64_t n, float *ux, float *uy, float *uz);

/* The same for a source of precision float64. */
typedef int64_t (*aomc_sky_next_double)(void *context, int64_t start, int64_t n, double *ux, double *uy, double *uz);

/* Write up to three numbers of each of the photons [start, start + n), uniform in [0, 1), and return how many photons
 * they are of; the answers are those of `next`. They are further coordinates of the low-discrepancy point of the photon:
 * use them for its first free path, scattering angle and azimuth. A pointer is NULL for a number that is not wanted. */
typedef int64_t (*aomc_sky_numbers)(void *context, int64_t start, int64_t n, float *n1, float *n2, float *n3);
typedef int64_t (*aomc_sky_numbers_double)(void *context, int64_t start, int64_t n, double *n1, double *n2, double *n3);

/* The photons of one band. Of two functions the one of the source's precision is there, the other is NULL. */
typedef struct aomc_sky_source {
    aomc_sky_next next;
    aomc_sky_next_double next_double;
    aomc_sky_numbers numbers;
    aomc_sky_numbers_double numbers_double;
    void *context;
    int64_t n_photons;
    double wavelength_nm;
} aomc_sky_source;

/* ---- For programs without Python: compile aomc_sky_embed.c with them. ----
 *
 * The functions below return 0, or -1 with the reason in aomc_sky_error(). Call them from one thread at a time;
 * the sources that they hand out are for any number of threads. Opening the first scene starts Python, about
 * a second, and the first use on a machine compiles for some seconds more. Which Python is started: the
 * environment variable AOMC_SKY_PYTHON (the path of an interpreter, also of a virtual environment), else the macro
 * of that name when this was compiled, else the python3 on the PATH. It is never ended, and leaves signals alone.
 */

typedef struct aomc_sky_scene aomc_sky_scene;

/* Open a scene: `path` is an amc.inp or its folder. `options` is NULL or words `name=value` with the names
 * of read_scene and Scene.source: iterations, sky, bins, weighting, compat, allocation, method, placement,
 * order, precision ("order=patch precision=float64"). */
int aomc_sky_open(const char *path, uint64_t seed, const char *options, aomc_sky_scene **scene);

/* Open a run folder: the photons of its plan, whatever was stored. */
int aomc_sky_open_run(const char *folder, aomc_sky_scene **scene);

/* Number of bands; 0 for NULL. */
int64_t aomc_sky_bands(const aomc_sky_scene *scene);

/* The photons of one band, valid until the scene is closed. */
int aomc_sky_band(aomc_sky_scene *scene, int64_t band, aomc_sky_source *source);

/* Close a scene; sources of it answer AOMC_SKY_CLOSED from now on. NULL is allowed. */
void aomc_sky_close(aomc_sky_scene *scene);

/* Why the last function of this thread failed; never NULL, "" after none. */
const char *aomc_sky_error(void);

#ifdef __cplusplus
}
#endif

#endif
