/* A difcol.inp for the AOMC program where the scene needs none, for as long as the program looks for one.
 *
 * With light source 0 the program opens difcol.inp before it asks `light` for a photon, and goes no further without it.
 * Where sky.toml says all, there is no such file. This one is written before the program starts and removed before the
 * first photon, or when the program ends. It gives every waveband the iterations of amc.inp, and a direct fraction of
 * -1, which the program takes and aomc-sky refuses: should it ever be left behind, by a killed program, nobody takes it
 * for a measurement.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FIRST_COLUMN = 48, LIGHT_SOURCE_LINE = 2, WAVEBANDS_LINE = 30 };

static int written;

void aomc_difcol_remove(void)
{
    if (written)
        unlink("difcol.inp");
    written = 0;
}

/* The whole number in columns 49 to 56 of a line of amc.inp, -1 if there is none. */
static long number_of_line(FILE *amc, int *at, int line)
{
    char field[9] = "";
    int column = 0, length = 0, c;
    while (*at < line - 1 && (c = getc(amc)) != EOF)
        *at += c == '\n';
    while ((c = getc(amc)) != EOF && c != '\n')
        if (column++ >= FIRST_COLUMN && length < 8)
            field[length++] = (char)c;
    *at += 1;
    char *end;
    const long number = strtol(field, &end, 10);
    return end == field ? -1 : number;
}

__attribute__((constructor)) static void write_difcol(void)
{
    FILE *amc = fopen("amc.inp", "r");
    if (!amc)
        return;
    int at = 0;
    const long source = number_of_line(amc, &at, LIGHT_SOURCE_LINE);
    const long bands = number_of_line(amc, &at, WAVEBANDS_LINE);
    fclose(amc);
    if (source != 0 || bands < 1 || bands > 500 || access("sky.toml", R_OK) != 0)
        return;
    const int file = open("difcol.inp", O_WRONLY | O_CREAT | O_EXCL, 0644);
    if (file < 0) {
        if (errno != EEXIST) /* the scene's own is left alone */
            fprintf(stderr, "aomc-sky: difcol.inp, which the program wants: %s\n", strerror(errno));
        return;
    }
    written = 1;
    atexit(aomc_difcol_remove);
    FILE *difcol = fdopen(file, "w");
    if (!difcol)
        return;
    fprintf(difcol, "%ld\n", bands);
    for (long k = 0; k < bands; k++)
        fputs("-1.0 1.0\n", difcol);
    fputs("# for the AOMC program alone: sky.toml says all; remove this file\n", difcol);
    fclose(difcol);
}
