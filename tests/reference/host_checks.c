/* Calls everything of aomc_sky_embed.h, right and wrong, and prints what comes back.
 *   host_checks SCENE RUN_FOLDER
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "aomc_sky_embed.h"

#define SHOW(name, value) printf("%s %" PRId64 "\n", name, (int64_t)(value))
#define TEXT(name) printf("%s: %s\n", name, aomc_sky_error())

int main(int argc, char **argv)
{
    float ux[8], uy[8], uz[8], again[3][8];
    aomc_sky_scene *scene = NULL, *run = NULL, *none = NULL;
    aomc_sky_source source, wide, late;
    double dx[8], dy[8], dz[8];

    if (argc != 3) {
        return 2;
    }
    SHOW("missing", aomc_sky_open("no such folder", 1, NULL, &none));
    TEXT("missing text");
    SHOW("missing scene is NULL", none == NULL);
    SHOW("option", aomc_sky_open(argv[1], 1, "presision=float64", &none));
    TEXT("option text");
    SHOW("null path", aomc_sky_open(NULL, 1, NULL, &none));
    TEXT("null path text");
    SHOW("no plan", aomc_sky_open_run(argv[1], &none));
    SHOW("bands of none", aomc_sky_bands(none));
    aomc_sky_close(none);

    SHOW("open", aomc_sky_open(argv[1], 18446744073709551615u, "iterations=1000", &scene));
    SHOW("error is empty", aomc_sky_error()[0] == 0);
    SHOW("bands", aomc_sky_bands(scene));
    SHOW("band -1", aomc_sky_band(scene, -1, &source));
    TEXT("band -1 text");
    SHOW("next of no band is NULL", source.next == NULL);
    SHOW("band beyond", aomc_sky_band(scene, aomc_sky_bands(scene), &source));
    SHOW("band 0", aomc_sky_band(scene, 0, &source));
    SHOW("photons", source.n_photons);
    SHOW("nm", source.wavelength_nm);
    SHOW("double is NULL", source.next_double == NULL);

    SHOW("eight", source.next(source.context, 0, 8, ux, uy, uz));
    memcpy(again[0], ux, sizeof ux);
    SHOW("none wanted", source.next(source.context, 0, 0, ux, uy, uz));
    SHOW("none wanted, no array", source.next(source.context, 0, 0, NULL, NULL, NULL));
    SHOW("last", source.next(source.context, source.n_photons - 3, 8, ux, uy, uz));
    SHOW("the rest is untouched", memcmp(ux + 3, again[0] + 3, 5 * sizeof *ux) == 0);
    SHOW("at the end", source.next(source.context, source.n_photons, 8, ux, uy, uz));
    SHOW("beyond", source.next(source.context, INT64_MAX, INT64_MAX, ux, uy, uz));
    SHOW("bad start", source.next(source.context, -1, 8, ux, uy, uz));
    SHOW("bad count", source.next(source.context, 0, -1, ux, uy, uz));
    SHOW("no array", source.next(source.context, 0, 8, ux, NULL, uz));
    SHOW("no context", source.next(NULL, 0, 8, ux, uy, uz));

    SHOW("second open", aomc_sky_open(argv[1], 3, "iterations=500 precision=float64 order=patch", &none));
    SHOW("wide", aomc_sky_band(none, 1, &wide));
    SHOW("single is NULL", wide.next == NULL);
    SHOW("eight wide", wide.next_double(wide.context, 4, 8, dx, dy, dz));
    late = source;
    aomc_sky_close(scene);
    SHOW("closed", late.next(late.context, 0, 8, ux, uy, uz));
    SHOW("other scene is open", wide.next_double(wide.context, 4, 8, dx, dy, dz));
    aomc_sky_close(none);

    SHOW("run", aomc_sky_open_run(argv[2], &run));
    SHOW("run band", aomc_sky_band(run, 0, &source));
    SHOW("run photons", source.n_photons);
    SHOW("run eight", source.next(source.context, 0, 8, again[0], again[1], again[2]));
    for (int k = 0; k < 8; k++) {
        uint32_t bits[3];
        for (int c = 0; c < 3; c++) {
            memcpy(&bits[c], &again[c][k], 4);
        }
        printf("photon %08" PRIx32 " %08" PRIx32 " %08" PRIx32 "\n", bits[0], bits[1], bits[2]);
    }
    aomc_sky_close(run);
    return 0;
}
