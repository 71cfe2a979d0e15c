/* Pure compaction: what is pressed is gone (dissertation 4.4.2). */
#include "deform/internal.h"

enum status deform_none(struct deform *deform, const struct deform_sweep *sweep, const struct deform_window *window,
			uint32_t layer)
{
	const struct press_params params = deform_press_params(deform, sweep, window, layer);
	return deform_press(deform, &params, sizeof params, window, layer);
}
