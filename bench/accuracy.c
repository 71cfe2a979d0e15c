#include <stdio.h>
#include "accuracy.h"
int main(int argc, char **argv)
{
	struct accuracy_truth truth;
	accuracy_truth_open(&truth, argc > 1 ? argv[1] : NULL);
	static const enum deform_model models[] = {DEFORM_NONE, DEFORM_BOX_FILTER, DEFORM_SLIPPAGE, DEFORM_SCM};
	for (int m = 0; m < 4; m++)
	for (double spacing = 1; spacing >= 1.0 / 64; spacing /= 2) {
		struct accuracy_drive drive = {.model = models[m], .spacing = spacing, .max_error = 0.001, .time_step = 0.02, .interval = 0.05, .laps = 1};
		struct accuracy_figures figures;
		double b = clock_seconds();
		accuracy_drive(&drive, &truth, &figures);
		printf("%s 1/%g max %.5f rms %.5f vol %.5f abs %.5f ms %.3f p99 %.3f steps %d slots %ld store %ld awake %d drift %g  %.2f s\n", accuracy_model_name(models[m]), 1 / spacing, figures.error.max, figures.error.rms, figures.error.volume, figures.error.volume_abs, figures.ms_step, figures.p99, (int)figures.steps, (long)figures.slot_bytes, (long)figures.store_bytes, (int)figures.awake, figures.drift, clock_seconds() - b);
		fflush(stdout);
	}
	accuracy_truth_close(&truth);
	return 0;
}
