/* Asks an .nsdf file for signed distances and directions to the surface, as a physics engine would: reads lines of
 * "time x y z" and prints the distance and its gradient for each.
 * Build: cc query_points.c $(pkg-config --cflags --libs nsdf) -o query_points */
#include <nsdf/decoder.h>

#include <stdio.h>

static nsdf_status query(nsdf_decoder *decoder) {
    double t;
    float point[3], distance, gradient[3];
    nsdf_status status = NSDF_OK;
    while (status == NSDF_OK && scanf("%lf %f %f %f", &t, &point[0], &point[1], &point[2]) == 4) {
        status = nsdf_evaluate(decoder, t, point, 1, &distance, gradient); /* many points at once are much faster */
        if (status == NSDF_OK)
            printf("%g %g %g %g\n", (double)distance, (double)gradient[0], (double)gradient[1], (double)gradient[2]);
    }
    return status;
}

int main(int argc, char **argv) {
    nsdf_decoder *decoder = NULL;
    nsdf_error error;
    if (argc != 2) {
        fprintf(stderr, "usage: query_points FILE.nsdf <POINTS\n");
        return 2;
    }
    if (nsdf_open_file(&decoder, argv[1], NULL, &error) != NSDF_OK) {
        fprintf(stderr, "query_points: %s: %s\n", argv[1], error.message);
        return 1;
    }
    const nsdf_status status = query(decoder);
    if (status != NSDF_OK)
        fprintf(stderr, "query_points: %s\n", nsdf_status_string(status));
    nsdf_close(&decoder);
    return status == NSDF_OK ? 0 : 1;
}
