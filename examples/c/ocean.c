/* Light in deep, even water below a flat surface, by the photons of a source file.
 *
 *     ocean FILE -d 1,5,10 [-p rayleigh|TABLE.csv] [-a albedo] [-c] [-n numbers] [-s stretch] [-r refractive index]
 *                [-i irradiance above the surface]
 *
 * At each optical depth it prints the irradiances Ed (downward), Eu (upward), Eou (upward, scalar) and the radiances Ld
 * (mean within 20 degrees of straight down) and Lu (straight up). Errors come from the replicates of the file.
 * A flight gives each depth what it gives on average over all free paths (expected values). With -c (crossings) it
 * gives its weight to the depths that it crosses, and at its end to Lu by the phase function.
 * -n: so many of the first choices (free path, scattering angle, azimuth) come from the source, 0 to 3.
 * -s: free paths have the density of exp(-(1 + stretch uz) s), so that more photons come deep. It must be less than the
 *     attenuation of Ed per optical depth. Weights make up for it. */
#include <unistd.h>

#include "example.h"

enum { ED, EU, EOU, LD, LU, QUANTITIES, DEPTHS = 8, PART = 2048, ROWS = 500, SLICES = 64 };
static const char *const names[] = {"Ed", "Eu", "Eou", "Ld", "Lu"};
static const double PI = 3.14159265358979323846, CONE = 0.93969262078590838; /* cosine of 20 degrees */

typedef struct { double at[QUANTITIES][DEPTHS], n; } score; /* n: photons */

static double albedo = 0.9, n_number = 3, stretch, refractive_index = 1.34, irradiance = -1;
static double depth[DEPTHS], deepest, narrow = 0.99619469809174555; /* cosine of 5 degrees */
static double rise_loss; /* per optical depth straight up: light that turns by less goes on, or Lu would be noisy */
static int n_depth, by_expectation = 1, n_bin;
static double away[ROWS * SLICES], share[ROWS * SLICES]; /* 1 - cosine at the edges of bins, and the light below them */

static void stop(const char *what, const char *value) { fprintf(stderr, "ocean: %s: %s\n", what, value), exit(2); }

/* Word k of a photon depends on its key and k alone (splitmix64), so threads change nothing. */
static uint64_t mixed(uint64_t z)
{
    z = (z ^ z >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ z >> 27) * UINT64_C(0x94D049BB133111EB);
    return z ^ z >> 31;
}

static double uniform(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    return ((double)(mixed(*state) >> 12) + 0.5) / 4503599627370496.0; /* never 0 and never 1 */
}

static int bin_of(const double *edges, double x)
{
    int low = 0;
    for (int step = 1 << 14; step > 0; step /= 2)
        if (low + step < n_bin && edges[low + step] <= x) low += step;
    return low;
}

/* Between two angles of the table the law is a power of the angle. In each thin slice of it light is even in solid
 * angle, so the cumulative has an exact inverse, and `phase` is the density of what `scattered` draws. */
static void read_table(const char *path)
{
    char line[256];
    double before = 0, p_before = 0, angle, p;
    FILE *file = fopen(path, "r");
    if (!file) stop("the file cannot be read", path);
    while (n_bin < (ROWS - 2) * SLICES && fgets(line, sizeof line, file)) {
        if (sscanf(line, "%lf%*[,; \t]%lf", &angle, &p) != 2) continue; /* a heading */
        if (!(angle > before && angle < 180.001 && p > 0)) stop("angles must ascend from above 0 to 180", line);
        const double step = log(angle / before) / SLICES, power = log(p / p_before) / step / SLICES;
        if (n_bin == 0 && before > 0) { /* below the first angle the power goes on */
            away[++n_bin] = 2 * pow(sin(before * PI / 360), 2);
            share[n_bin] = p_before * before * before * PI / 180 / (power + 2);
        }
        for (int slice = 0; slice < SLICES && before > 0; slice++) {
            const double middle = before * exp((slice + 0.5) * step), edge = before * exp((slice + 1) * step);
            away[++n_bin] = 2 * pow(sin(edge * PI / 360), 2);
            share[n_bin] = share[n_bin - 1];
            share[n_bin] += p_before * pow(middle / before, power) * sin(middle * PI / 180) * middle * step;
        }
        before = angle, p_before = p;
    }
    fclose(file);
    if (n_bin == 0 || before < 179.999) stop("the phase function must end at 180 degrees, in few rows", path);
    for (int i = 0; i < n_bin; i++) share[i] /= share[n_bin];
    away[n_bin] = 2, share[n_bin] = 1;
}

/* Per sr, for the cosine of a scattering angle. */
static double phase(double mu)
{
    if (!n_bin) return 3 / (16 * PI) * (1 + mu * mu); /* Rayleigh */
    const int i = bin_of(away, 1 - mu);
    return (share[i + 1] - share[i]) / (away[i + 1] - away[i]) / (2 * PI);
}

/* The cosine of the angle below which a share u of the light is scattered. */
static double scattered(double u)
{
    if (!n_bin) {
        const double a = 2 - 4 * u, root = cbrt(fabs(a) + sqrt(a * a + 1));
        return copysign(root - 1 / root, a);
    }
    const int i = bin_of(share, u);
    return 1 - away[i] - (away[i + 1] - away[i]) * (u - share[i]) / (share[i + 1] - share[i]);
}

/* The cosine behind a surface, 0 where all light is reflected. n is the refractive index there over that before it. */
static double refracted(double mu, double n) { return sqrt(fmax(1 - (1 - mu * mu) / (n * n), 0)); }

/* Fresnel, for light without polarisation. */
static double reflectance(double mu, double n)
{
    const double behind = refracted(mu, n);
    if (mu <= 0 || behind <= 0) return 1;
    const double across = (mu - n * behind) / (mu + n * behind), along = (n * mu - behind) / (n * mu + behind);
    return (across * across + along * along) / 2;
}

/* Near the horizon 1 / mu has no bound, so its mean stands for it, which is 1 / 0.005 for even radiance. */
static void count(score *s, int k, double mu, double weight)
{
    s->at[mu < 0 ? ED : EU][k] += weight;
    if (mu > 0) s->at[EOU][k] += weight / (mu < 0.01 ? 0.005 : mu);
    if (mu < -CONE) s->at[LD][k] -= weight / mu;
}

/* A flight without an end. At a distance s a share exp(-s) is left of it, and all along it scatters straight up. */
static void expect(score *s, double tau, double mu, double weight)
{
    const double m = fabs(mu), to_zenith = albedo * phase(mu);
    for (int k = 0; k < n_depth; k++) {
        const double ahead = mu < 0 ? depth[k] - tau : tau - depth[k], rise = weight * exp(-rise_loss * fabs(ahead));
        const double there = ahead < 0 ? 0 : weight * exp(-ahead / m);
        if (mu < 0) s->at[LU][k] += to_zenith * (ahead < 0 ? rise : there) / (1 + rise_loss * m);
        else if (ahead > 0 && mu < narrow) s->at[LU][k] += to_zenith * (rise - there) / (1 - rise_loss * m);
        if (ahead > 0 || (mu < 0 && ahead >= 0)) count(s, k, mu, there);
    }
}

/* A part of a flight, `before` away from its start. Stretching adds weight at the rate `grows`. */
static void cross(score *s, double from, double to, double mu, double weight, double before, double grows)
{
    for (int k = 0; k < n_depth; k++)
        if (mu < 0 ? from <= depth[k] && depth[k] < to : to <= depth[k] && depth[k] < from)
            count(s, k, mu, weight * exp(grows * (before + fabs(depth[k] - from) / fabs(mu))));
}

static void follow(score *s, uint64_t state, const float *given, double x, double y, double z)
{
    double tau = 0, weight = 1 - reflectance(-z, refractive_index);
    x /= refractive_index, y /= refractive_index, z = -refracted(-z, refractive_index);
    for (int event = 0; weight > 0; event++) {
        double u[3];
        for (int k = 0; k < 3; k++) u[k] = uniform(&state);
        for (int k = 0; event == 0 && k < n_number; k++) u[k] = given[k] + u[k] / 16777216; /* in their last bit */
        const double rate = tau < deepest ? 1 + stretch * z : 1, path = -log(u[0]) / rate;
        const double up = z > 0 ? tau / z : INFINITY, end = fabs(tau - path * z); /* the surface is `up` away */
        const double back = z > 0 ? weight * reflectance(z, 1 / refractive_index) : 0;
        if (by_expectation) {
            expect(s, tau, z, weight);
            if (back * exp(-up) > 0) expect(s, 0, -z, back * exp(-up));
        } else {
            cross(s, tau, path > up ? 0 : end, z, weight, 0, rate - 1);
            if (path > up) cross(s, 0, end, -z, back, up, rate - 1);
        }
        if (path > up) z = -z, weight = back;
        tau = end, weight *= albedo * exp((rate - 1) * path) / rate;
        for (int k = 0; !by_expectation && k < n_depth; k++)
            if (depth[k] < tau && z < narrow) s->at[LU][k] += weight * phase(z) * exp(rise_loss * (depth[k] - tau));
        if (weight * exp(stretch * fmin(tau, deepest)) < 0.01) /* roulette, by what it is worth at the deepest depth */
            weight = uniform(&state) < 0.1 ? 10 * weight : 0;
        const double mu = scattered(u[1]), across = sqrt(fmax(1 - mu * mu, 0));
        const double a = across * cos(2 * PI * u[2]), b = across * sin(2 * PI * u[2]);
        const double flat = sqrt(x * x + y * y), cosine = flat > 1e-9 ? x / flat : 1, sine = flat > 1e-9 ? y / flat : 0;
        x = mu * x + a * z * cosine - b * sine;
        y = mu * y + a * z * sine + b * cosine;
        z = mu * z - a * flat;
        const double length = sqrt(x * x + y * y + z * z); /* rounding would add up */
        x /= length, y /= length, z = copysign(fmax(fabs(z / length), 1e-9), z);
    }
}

static void add(score *sum, const score *part)
{
    for (int q = 0; q < QUANTITIES; q++)
        for (int k = 0; k < n_depth; k++) sum->at[q][k] += part->at[q][k];
    sum->n += part->n;
}

/* The photons of a replicate. Parts are added in their order, for any number of threads. */
static score run(const aomc_sky_source *source, uint64_t key)
{
    score sum = {.n = (double)source->n};
#pragma omp parallel for ordered schedule(dynamic)
    for (int64_t start = 0; start < source->n; start += PART) {
        float ux[PART], uy[PART], uz[PART], n1[PART], n2[PART], n3[PART];
        score own = {.n = 0};
        const int64_t n = need(aomc_sky_fill(source, start, PART, ux, uy, uz));
        need(aomc_sky_numbers(source, start, PART, n1, n2, n3));
        for (int64_t i = 0; i < n; i++)
            follow(&own, mixed(key + (uint64_t)(start + i)), (float[]){n1[i], n2[i], n3[i]}, ux[i], uy[i], uz[i]);
#pragma omp ordered
        add(&sum, &own);
    }
    return sum;
}

static void read_option(int option, char *text)
{
    static double *const numbers[128] = {
        ['a'] = &albedo, ['n'] = &n_number, ['s'] = &stretch, ['r'] = &refractive_index, ['i'] = &irradiance};
    if (numbers[option]) *numbers[option] = atof(text);
    else if (option == 'p' && strcmp(text, "rayleigh")) read_table(text);
    else if (option == 'c') by_expectation = 0;
    else if (option == '?') exit(2);
    for (char *word = option == 'd' ? strtok(text, ",") : NULL; word; word = strtok(NULL, ",")) {
        if (n_depth == DEPTHS) stop("too many depths", word);
        deepest = fmax(deepest, depth[n_depth++] = atof(word));
    }
}

int main(int argc, char **argv)
{
    static score runs[4096], sum; /* a file has no more replicates */
    aomc_sky_file file;
    aomc_sky_source source;
    uint64_t key;
    for (int option; (option = getopt(argc, argv, "p:a:d:cn:s:r:i:")) != -1;) read_option(option, optarg);
    if (optind != argc - 1) stop("usage", "ocean FILE [options], see the first lines of ocean.c");
    if (!(albedo >= 0 && albedo < 1 && stretch >= 0 && stretch < 1)) stop("not 0 to below 1", "albedo or stretch");
    if (n_depth == 0) stop("no depths", "write -d 1,5,10");
    const int bin = bin_of(away, 1 - narrow);
    if (n_bin) narrow = 1 - away[bin];
    rise_loss = 1 - albedo * (n_bin ? share[bin] : (4 - narrow * (narrow * narrow + 3)) / 8);
    need(aomc_sky_load(argv[optind], &file));
    memcpy(&key, file.plan_sha256, sizeof key); /* another file, other random numbers */
    for (int r = 0; r < file.n_replicates; r++) {
        need(aomc_sky_replicate(&file, 0, r, &source));
        runs[r] = run(&source, mixed(mixed(key) + (uint64_t)r));
        add(&sum, runs + r);
    }
    if (irradiance < 0) irradiance = isnan(source.irradiance_W_m2_nm) ? 1 : source.irradiance_W_m2_nm;
    printf("%.0f photons, %d replicates\n   depth               value  std. error\n", sum.n, (int)file.n_replicates);
    for (int q = 0; q < QUANTITIES; q++)
        for (int k = 0; k < n_depth; k++) {
            const double unit = irradiance / (q == LD ? 2 * PI * (1 - CONE) : 1), mean = sum.at[q][k] / sum.n;
            double squares = 0;
            for (int r = 0; r < file.n_replicates; r++) squares += pow(runs[r].at[q][k] - runs[r].n * mean, 2);
            printf("%8g %-3s %15.8g %11.3g\n", depth[k], names[q], unit * mean,
                   unit * sqrt(file.n_replicates / (file.n_replicates - 1.0) * squares) / sum.n);
        }
    return aomc_sky_unload(&file), 0;
}
