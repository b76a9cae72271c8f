/* The photons of a scene in a C program: mean cosine and scalar-to-planar ratio of every band, any number of threads.
 *
 *   sky_means SCENE SEED [OPTIONS [FILE]]
 *
 * SCENE is amc.inp or its folder, OPTIONS are words like "precision=float32 order=patch". FILE, if named, gets
 * the directions as they come: all ux of a band, then all uy, then all uz, little-endian float32.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aomc_sky_embed.h"

#define BATCH 65536

typedef struct {
    double cosine, inverse;
} sums;

/* Every batch is a task of its own: photons depend on their index alone, so threads share nothing. */
static sums follow(const aomc_sky_source *source, float *directions)
{
    const int64_t n = source->n_photons;
    double cosine = 0, inverse = 0;
    int64_t failed = 0;

#pragma omp parallel for reduction(+ : cosine, inverse, failed) schedule(dynamic)
    for (int64_t start = 0; start < n; start += BATCH) {
        float *ux = directions + start, *uy = ux + n, *uz = uy + n;
        const int64_t wanted = n - start < BATCH ? n - start : BATCH;
        if (source->next(source->context, start, wanted, ux, uy, uz) != wanted) {
            failed++;
            continue;
        }
        for (int64_t i = 0; i < wanted; i++) { /* here your photon goes its way */
            cosine += -uz[i];
            inverse += -1.0 / uz[i];
        }
    }
    if (failed) {
        fprintf(stderr, "%" PRId64 " batches failed\n", failed);
        exit(1);
    }
    return (sums){cosine, inverse};
}

static void die(const char *what)
{
    fprintf(stderr, "%s: %s\n", what, aomc_sky_error());
    exit(1);
}

int main(int argc, char **argv)
{
    aomc_sky_scene *scene;
    FILE *file = NULL;
    char *end;

    if (argc < 3 || argc > 5) {
        fprintf(stderr, "usage: %s SCENE SEED [OPTIONS [FILE]]\n", argv[0]);
        return 2;
    }
    const uint64_t seed = strtoull(argv[2], &end, 10);
    if (end == argv[2] || *end != '\0' || strchr(argv[2], '-') != NULL) {
        fprintf(stderr, "SEED is no whole number from 0\n");
        return 2;
    }
    if (aomc_sky_open(argv[1], seed, argc > 3 ? argv[3] : NULL, &scene) != 0) {
        die(argv[1]);
    }
    if (argc > 4 && (file = fopen(argv[4], "wb")) == NULL) {
        perror(argv[4]);
        return 1;
    }
    printf("%10s %12s %12s %12s\n", "nm", "photons", "mean cosine", "Eo/Ed");
    for (int64_t band = 0; band < aomc_sky_bands(scene); band++) {
        aomc_sky_source source;
        if (aomc_sky_band(scene, band, &source) != 0) {
            die("band");
        }
        if (source.next == NULL) {
            fprintf(stderr, "this program takes float32\n");
            return 1;
        }
        const size_t n = (size_t)source.n_photons;
        float *directions = malloc(3 * n * sizeof *directions + 1);
        if (directions == NULL) {
            fprintf(stderr, "out of memory\n");
            return 1;
        }
        const sums found = follow(&source, directions);
        printf("%10g %12" PRId64 " %12.6f %12.6f\n", source.wavelength_nm, source.n_photons,
               n ? found.cosine / (double)n : 0.0, n ? found.inverse / (double)n : 0.0);
        if (file != NULL && fwrite(directions, sizeof *directions, 3 * n, file) != 3 * n) {
            perror(argv[4]);
            return 1;
        }
        free(directions);
    }
    aomc_sky_close(scene);
    return file != NULL && fclose(file) != 0;
}
