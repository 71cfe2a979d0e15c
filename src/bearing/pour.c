#include "bearing/pour.h"

/* Returns the thickness of the loose layers on a post: of what came since a body touched it, and of an older one. */
static int64_t loose_on(void *const planes[PLANES], size_t at)
{
	const int32_t *deposited = planes[PLANE_DEPOSITED], *settled = planes[PLANE_SETTLED], *loose = planes[PLANE_LOOSE];
	if (deposited == NULL || settled == NULL)
		return 0;
	const int64_t came = (int64_t)deposited[at] - settled[at];
	return (came > 0 ? came : 0) + (loose != NULL ? loose[at] : 0);
}

/* Makes the surface one of ground that nothing has touched. */
static void forget(void *const planes[PLANES], size_t at, int32_t offset)
{
	static const enum plane zeros[] = {PLANE_PLASTIC_SINKAGE, PLANE_SHEAR, PLANE_DUG, PLANE_LOOSE, PLANE_FLOOR, PLANE_DENSITY};
	static const enum plane surfaces[] = {PLANE_DEPOSITED, PLANE_SETTLED};
	for (size_t i = 0; i < sizeof zeros / sizeof *zeros; i++)
		if (planes[zeros[i]] != NULL)
			((int32_t *)planes[zeros[i]])[at] = 0;
	for (size_t i = 0; i < sizeof surfaces / sizeof *surfaces; i++)
		if (planes[surfaces[i]] != NULL)
			((int32_t *)planes[surfaces[i]])[at] = offset;
	if (planes[PLANE_DISTURBANCE] != NULL)
		((uint8_t *)planes[PLANE_DISTURBANCE])[at] = 0;
}

void bearing_pour(void *const planes[PLANES], size_t at, int32_t amount, bool loose)
{
	int32_t *offset = planes[PLANE_OFFSET], *deposited = planes[PLANE_DEPOSITED];
	const bool lies_on_top = amount > 0 ? loose : -(int64_t)amount < loose_on(planes, at);
	if (amount == 0)
		return;
	offset[at] += amount;
	if (!lies_on_top)
		forget(planes, at, offset[at]);
	else if (deposited != NULL)
		deposited[at] += amount;
}
