/* One impact: cc -std=c99 example.c -lm && ./a.out $diameter 0.5 1.2 0
 * (diameter, normal and tangential speed, spin) */
#include <stdio.h>
#include <stdlib.h>

#include "microimpact_rebound.h"

int main(int count, char **words)
{
    double normal, tangential, spin;

    if (count != 5) {
        fprintf(stderr, "give diameter (m), normal speed (m/s), tangential speed (m/s), spin (rad/s)\n");
        return 2;
    }
    switch (microimpact_rebound(atof(words[1]), -atof(words[2]), atof(words[3]), atof(words[4]),
                                &normal, &tangential, &spin)) {
    case 0:
        printf("rebounds: %.9g m/s, %.9g m/s, %.9g rad/s\n", normal, tangential, spin);
        return 0;
    case 1:
        printf("captured: rolls on with %.9g m/s, %.9g rad/s\n", tangential, spin);
        return 0;
    case -2:
        fprintf(stderr, "the diameter must be from %g to %g m\n", MICROIMPACT_SMALLEST,
                MICROIMPACT_LARGEST);
        return 2;
    default:
        fprintf(stderr, "the normal speed must be above 0 and below %g m/s\n", MICROIMPACT_FASTEST);
        return 2;
    }
}
