/* Chooses the widest of the copies of bear.c that the processor can run. Each is compiled for one instruction set (meson.build); all give the same bits. */
#include "soil/law/bear.h"

typedef void bear_copy(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
		       struct soil_changes *changes);
bear_copy soil_bear_plain, soil_bear_layered_plain;

#ifdef FURROW_LAW_AVX512
bear_copy soil_bear_avx512, soil_bear_layered_avx512;
#define IN_AVX512(name) __builtin_cpu_supports("x86-64-v4") ? name##_avx512:
#else
#define IN_AVX512(name)
#endif

#ifdef FURROW_LAW_AVX2
bear_copy soil_bear_avx2, soil_bear_layered_avx2;
#define IN_AVX2(name) __builtin_cpu_supports("avx2") ? name##_avx2:
#else
#define IN_AVX2(name)
#endif

#define WIDEST(name) (IN_AVX512(name) IN_AVX2(name) name##_plain)

void soil_bear(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
	       struct soil_changes *changes)
{
	WIDEST(soil_bear)(form, posts, raised, share, sums, kept, changes);
}

void soil_bear_layered(const struct soil_form *form, const struct soil_posts *posts, int32_t raised, float share, struct soil_sums *sums, struct soil_kept *kept,
		       struct soil_changes *changes)
{
	WIDEST(soil_bear_layered)(form, posts, raised, share, sums, kept, changes);
}
