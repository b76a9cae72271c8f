/* The photons of aomc-sky in a program written in C, C++ or Fortran.
 *
 * One function and its context give the photons of a band. They come from PhotonSource.c_source(band) in Python,
 * or from aomc_sky_band() below if the program starts Python itself; only then it needs aomc_sky_embed.c.
 * The function needs no lock and no Python. Any number of threads may call it at once. Photon i of a band is the
 * same in every thread, so parallel programs take ranges that do not overlap.
 *
 * Bands and photons count from 0. Directions are unit vectors of travel with z up: uz <= 0.
 */
#ifndef AOMC_SKY_EMBED_H
#define AOMC_SKY_EMBED_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Errors of `next` and `numbers`. */
enum {
    AOMC_SKY_CLOSED = -1,    /* the context is NULL, or its source was closed or dropped */
    AOMC_SKY_BAD_START = -2, /* start < 0 */
    AOMC_SKY_BAD_COUNT = -3, /* n < 0 */
    AOMC_SKY_NO_ARRAY = -4   /* a pointer to directions is NULL, or all three pointers to numbers are */
};

/* Write the directions of the photons [start, start + n) and return the number of photons: fewer than n at the end
 * of the band, then 0. A negative answer is an error, and nothing is written. The arrays have at least n entries
 * each and do not overlap. */
typedef int64_t (*aomc_sky_next)(void *context, int64_t start, int64_t n, float *ux, float *uy, float *uz);

/* The same for a source of precision float64. */
typedef int64_t (*aomc_sky_next_double)(void *context, int64_t start, int64_t n, double *ux, double *uy, double *uz);

/* Write up to three numbers in [0, 1) of each of the photons [start, start + n). The answers are those of `next`.
 * The numbers are further coordinates of the low-discrepancy point of the photon. Use them for its first free path,
 * its first scattering angle and the azimuth of that scattering. A pointer may be NULL: then its number is left out. */
typedef int64_t (*aomc_sky_numbers)(void *context, int64_t start, int64_t n, float *n1, float *n2, float *n3);
typedef int64_t (*aomc_sky_numbers_double)(void *context, int64_t start, int64_t n, double *n1, double *n2, double *n3);

/* The photons of one band. Functions of the other precision are NULL. */
typedef struct aomc_sky_source {
    aomc_sky_next next;
    aomc_sky_next_double next_double;
    void *context;
    int64_t n_photons;
    double wavelength_nm;
    aomc_sky_numbers numbers;
    aomc_sky_numbers_double numbers_double;
} aomc_sky_source;

/* ---- For programs without Python: compile aomc_sky_embed.c with them. ----
 *
 * The functions below return 0, or -1 with the reason in aomc_sky_error(). Call them from one thread at a time.
 * Their sources are for any number of threads. The first scene starts Python in about a second. The first use on a
 * machine compiles for some seconds more. The environment variable AOMC_SKY_PYTHON names the Python (the path of an
 * interpreter, also of a virtual environment). Without it, it is the macro of that name at compile time, or else
 * python3 on the PATH. Python is never ended, and it does not touch signals.
 */

typedef struct aomc_sky_scene aomc_sky_scene;

/* Open a scene: `path` is an amc.inp or its folder. `options` is NULL or words `name=value`, arguments of
 * read_scene and Scene.source: iterations, sky, bins, weighting, compat, allocation, method, placement,
 * order, precision ("order=patch precision=float64"). */
int aomc_sky_open(const char *path, uint64_t seed, const char *options, aomc_sky_scene **scene);

/* Open a run folder: the photons of its plan, whether they were stored or not. */
int aomc_sky_open_run(const char *folder, aomc_sky_scene **scene);

/* Number of bands; 0 for NULL. */
int64_t aomc_sky_bands(const aomc_sky_scene *scene);

/* The photons of one band, valid until the scene is closed. */
int aomc_sky_band(aomc_sky_scene *scene, int64_t band, aomc_sky_source *source);

/* Close a scene. Its sources answer AOMC_SKY_CLOSED from now on. NULL is allowed. */
void aomc_sky_close(aomc_sky_scene *scene);

/* The reason for the last failure in this thread; "" if none failed, never NULL. */
const char *aomc_sky_error(void);

#ifdef __cplusplus
}
#endif

#endif
