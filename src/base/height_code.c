#include "base/height_code.h"

#include "base/wide.h"

#define UNITS_MOST 2147483000.0
/* Added and taken away again it leaves a double of at most 2^51 rounded to a whole number, ties to even. */
#define ROUNDER 6755399441055744.0

/* Without branches, so that it becomes vector code; what cannot be coded becomes 0 and is told. */
FURROW_WIDE static bool row_of_steps(const double *metres, int64_t count, double step, int32_t *codes)
{
	unsigned bad = 0;
	for (int64_t i = 0; i < count; i++) {
		double units = metres[i] / step;
		bool hole = metres[i] != metres[i], fits = fabs(units) <= UNITS_MOST;
		double whole = (fits ? units : 0) + ROUNDER - ROUNDER;
		codes[i] = hole ? HEIGHT_CODE_NODATA : (int32_t)whole;
		bad |= !hole & !fits;
	}
	return bad == 0;
}

int64_t height_code_row(const double *metres, int64_t count, double step, int32_t *codes)
{
	if (step > 0 && row_of_steps(metres, count, step, codes))
		return count;
	for (int64_t i = 0; i < count; i++)
		if (!height_code_encode(metres[i], step, &codes[i]))
			return i;
	return count;
}
