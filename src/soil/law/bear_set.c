/* Chooses the widest of the copies of bear.c that the processor can run. Each is compiled for one instruction set (meson.build); all give the same bits. */
#include "soil/law/bear.h"

typedef void bear_copy(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
		       struct soil_changes *changes);
bear_copy soil_bear_plain, soil_bear_avx2, soil_bear_avx512, soil_bear_layered_plain, soil_bear_layered_avx2, soil_bear_layered_avx512;

static bear_copy *copy_of(bear_copy *plain, bear_copy *avx2, bear_copy *avx512)
{
	return __builtin_cpu_supports("x86-64-v4") ? avx512 : __builtin_cpu_supports("avx2") ? avx2 : plain;
}

void soil_bear(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
	       struct soil_changes *changes)
{
	copy_of(soil_bear_plain, soil_bear_avx2, soil_bear_avx512)(form, posts, raised, share, sums, kept, changes);
}

void soil_bear_layered(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
		       struct soil_changes *changes)
{
	copy_of(soil_bear_layered_plain, soil_bear_layered_avx2, soil_bear_layered_avx512)(form, posts, raised, share, sums, kept, changes);
}
