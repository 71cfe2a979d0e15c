/* Pure compaction: what is pressed is gone (dissertation 4.4.2). */
#include "deform/internal.h"

enum status deform_none(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			uint32_t layer)
{
	const struct gpu_program_request request = {
		.vertex = "full.vert",
		.fragment = "deform/none.frag",
		.defines = {deform->contacts != NULL ? "CONTACT" : NULL},
	};
	const struct press_params params = deform_press_params(deform, sweep, window, layer);
	return deform_press(deform, &request, &deform->none, &params, sizeof params, window, layer);
}
