/* Writes n1, n2, n3 of all photons of the first band, as they come in ranges of 700, as bytes.
 *   numbers SCENE OPTIONS FILE
 */
#include <stdio.h>
#include <stdlib.h>

#include "aomc_sky_embed.h"

int main(int argc, char **argv)
{
    aomc_sky_scene *scene;
    aomc_sky_source source;
    if (argc != 4 || aomc_sky_open(argv[1], 3, argv[2], &scene) != 0 || aomc_sky_band(scene, 0, &source) != 0) {
        fprintf(stderr, "%s\n", aomc_sky_error());
        return 1;
    }
    const size_t width = source.numbers != NULL ? sizeof(float) : sizeof(double);
    const int64_t n = source.n_photons;
    char *out = malloc(3 * (size_t)n * width);
    for (int64_t start = 0, m = 700; start < n; start += m) {
        char *at = out + (size_t)start * width, *second = at + (size_t)n * width, *third = second + (size_t)n * width;
        m = n - start < 700 ? n - start : 700;
        if (source.numbers != NULL
                ? source.numbers(source.context, start, m, (float *)at, (float *)second, (float *)third) != m
                : source.numbers_double(source.context, start, m, (double *)at, (double *)second, (double *)third) != m) {
            return 1;
        }
    }
    FILE *file = fopen(argv[3], "wb");
    if (file == NULL || fwrite(out, width, 3 * (size_t)n, file) != 3 * (size_t)n) {
        return 1;
    }
    free(out);
    aomc_sky_close(scene);
    return fclose(file);
}
