/* A transport code's end of the pipe: reads little-endian float32 records from standard input, as many numbers each as
 * the argument says. Prints the records, the sum of their bit patterns, that sum weighted with their place (both modulo
 * 2^64), the largest uz, and the largest distance of a direction's length from 1. */
#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int main(int argc, char **argv)
{
    size_t columns = argc > 1 ? (size_t)atoi(argv[1]) : 3;
    float *record = malloc(columns * sizeof *record);
    uint64_t n = 0, place = 0, sum = 0, weighted = 0;
    float largest_uz = -2.0f;
    double distance = 0.0;

    if (record == NULL || columns < 3)
        return 2;
    while (fread(record, sizeof *record, columns, stdin) == columns) {
        for (size_t k = 0; k < columns; ++k) {
            uint32_t word;
            memcpy(&word, &record[k], sizeof word);
            sum += word;
            weighted += ++place * word;
        }
        double x = record[0], y = record[1], z = record[2];
        double off = fabs(sqrt(x * x + y * y + z * z) - 1.0);
        distance = off > distance ? off : distance;
        largest_uz = record[2] > largest_uz ? record[2] : largest_uz;
        ++n;
    }
    if (ferror(stdin) || !feof(stdin))
        return 1;
    printf("%" PRIu64 " %" PRIu64 " %" PRIu64 " %.9g %.3g\n", n, sum, weighted, largest_uz, distance);
    free(record);
    return 0;
}
