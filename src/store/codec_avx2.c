/*
 * The codec's inner loops for x86-64 with AVX2, and the choice between them and the plain ones.
 *
 * Eight residuals of w bits are w bytes. Each half of a register loads 16 bytes, which hold four residuals; the second half
 * begins at bit 4 w. A shuffle moves the four bytes around each residual into its lane. A shift and a mask then cut it out.
 * This works up to 25 bits (7 + 25 = 32). Only lossless floats have wider blocks, and plain C decodes them.
 */
#include "store/codec_kernels.h"

#if defined(__x86_64__)

#include <immintrin.h>

#define WIDTH_MOST 25
#define AVX2 __attribute__((target("avx2")))

/* Lane l, residual l of 8: `bit` is where it begins in its half. */
struct unpack {
	__m256i shuffle, shift, mask;
};

AVX2 static struct unpack plan_of(unsigned width)
{
	_Alignas(32) uint8_t shuffle[32];
	_Alignas(32) uint32_t shift[8];
	for (unsigned lane = 0; lane < 8; lane++) {
		unsigned bit = lane < 4 ? lane * width : lane * width - width / 2 * 8;
		for (unsigned byte = 0; byte < 4; byte++) {
			unsigned at = bit / 8 + byte; /* beyond the half: never part of the residual */
			shuffle[4 * lane + byte] = (uint8_t)(at < 16 ? at : 0x80);
		}
		shift[lane] = bit % 8;
	}
	return (struct unpack){
		_mm256_load_si256((const __m256i *)shuffle),
		_mm256_load_si256((const __m256i *)shift),
		_mm256_set1_epi32((int)((1u << width) - 1)),
	};
}

AVX2 static inline __m256i unpack8(const uint8_t *from, unsigned width, const struct unpack *plan)
{
	__m128i low = _mm_loadu_si128((const __m128i *)(const void *)from);
	__m128i high = _mm_loadu_si128((const __m128i *)(const void *)(from + width / 2));
	__m256i z = _mm256_inserti128_si256(_mm256_castsi128_si256(low), high, 1);
	z = _mm256_and_si256(_mm256_srlv_epi32(_mm256_shuffle_epi8(z, plan->shuffle), plan->shift), plan->mask);
	__m256i sign = _mm256_sub_epi32(_mm256_setzero_si256(), _mm256_and_si256(z, _mm256_set1_epi32(1)));
	return _mm256_xor_si256(_mm256_srli_epi32(z, 1), sign);
}

AVX2 static const uint8_t *avx2_unpack(const uint8_t *from, const uint8_t *widths, size_t count, uint32_t *rest)
{
	struct unpack plans[WIDTH_MOST + 1];
	uint32_t planned = 0;
	for (size_t block = 0; block < count; block++, rest += CODEC_BLOCK) {
		unsigned width = widths[block];
		if (width > WIDTH_MOST) {
			store_codec_plain.unpack(from, widths + block, 1, rest);
		} else {
			if ((planned >> width & 1) == 0) {
				plans[width] = plan_of(width);
				planned |= 1u << width;
			}
			_mm256_storeu_si256((__m256i *)(void *)rest, unpack8(from, width, &plans[width]));
			_mm256_storeu_si256((__m256i *)(void *)(rest + 8),
					    unpack8(from + width, width, &plans[width]));
		}
		from += (size_t)2 * width;
	}
	return from;
}

/* Running sums of eight lanes. */
AVX2 static inline __m256i scan8(__m256i v)
{
	v = _mm256_add_epi32(v, _mm256_slli_si256(v, 4));
	v = _mm256_add_epi32(v, _mm256_slli_si256(v, 8));
	/* The lower half's last sum, to all of the upper half. */
	__m256i low = _mm256_permute2x128_si256(v, v, 0x08);
	return _mm256_add_epi32(v, _mm256_shuffle_epi32(low, 0xff));
}

AVX2 static inline __m256i last_of(__m256i v)
{
	return _mm256_permutevar8x32_epi32(v, _mm256_set1_epi32(7));
}

/* After a row's first post its posts are a whole number of eights: cells are a power of two from 8. */
AVX2 static void sum_row(const uint32_t *r, const int32_t *before, uint32_t side, bool slope, int32_t *row)
{
	__m256i sum = _mm256_set1_epi32((int)r[0]), step = _mm256_setzero_si256();
	row[0] = (int32_t)(r[0] + (uint32_t)before[0]);
	for (uint32_t x = 1; x < side; x += 8) {
		__m256i v = scan8(_mm256_loadu_si256((const __m256i *)(const void *)(r + x)));
		if (slope) {
			__m256i steps = _mm256_add_epi32(v, step);
			step = _mm256_add_epi32(step, last_of(v));
			v = scan8(steps);
		}
		__m256i posts = _mm256_add_epi32(v, sum);
		sum = _mm256_add_epi32(sum, last_of(v));
		posts = _mm256_add_epi32(posts, _mm256_loadu_si256((const __m256i *)(const void *)(before + x)));
		_mm256_storeu_si256((__m256i *)(void *)(row + x), posts);
	}
}

AVX2 static void avx2_sum(const uint32_t *rest, uint32_t side, uint32_t rows, const int32_t *before, bool slope,
			  int32_t *posts)
{
	for (uint32_t y = 0; y < rows; y++, rest += side, before = posts, posts += side)
		sum_row(rest, before, side, slope, posts);
}

static const struct codec_kernels codec_avx2 = {"avx2", avx2_unpack, avx2_sum};

const struct codec_kernels *store_codec_kernels_best(void)
{
	return __builtin_cpu_supports("avx2") ? &codec_avx2 : &store_codec_plain;
}

#else

const struct codec_kernels *store_codec_kernels_best(void)
{
	return &store_codec_plain;
}

#endif
