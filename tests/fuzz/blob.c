/*
 * Tile blobs: one that is hostile does no harm and takes no memory, and what is encoded comes back.
 *
 * An input: side of the plane, codec, then the blob. What decodes are posts; they, and the blob's
 * bytes taken for posts in several ways, are encoded and decoded again.
 */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

#include "store/codec.h"
#include "store/codec_kernels.h"

#define HEAD 2
#define KINDS 8
/* What the codec may hold for a post: its residuals, its planes, a body and what is made of it. */
#define BYTES_A_POST (32 + 8) /* and a round's copies */
#define BYTES_MORE (1u << 20) /* LZ4's tables */

const size_t fuzz_size_max = 16384;
const char *const fuzz_words[] = {NULL};

static const uint32_t sides[] = {9, 17, 9, 33, 9, 65, 17, 129};

static uint32_t side_of(uint8_t byte)
{
	/* The largest there is takes long: seldom. */
	return byte == 255 ? 1025 : sides[byte % (sizeof sides / sizeof *sides)];
}

static int64_t codec_of(uint8_t byte)
{
	return byte < 16 ? byte : (int8_t)byte;
}

static void check_round(struct codec *codec, const int32_t *posts)
{
	const void *bytes;
	size_t size, count = (size_t)codec->side * codec->side;
	int64_t id = store_codec_encode(codec, posts, &bytes, &size);
	fuzz_check(size <= store_codec_bound(codec));
	/* Decoding uses the codec's scratch, where the bytes are. */
	void *copy = malloc(size);
	int32_t *back = malloc(count * sizeof *back);
	fuzz_check(copy != NULL && back != NULL);
	memcpy(copy, bytes, size);
	fuzz_check(store_codec_decode(codec, id, copy, size, back));
	fuzz_check(memcmp(back, posts, count * sizeof *back) == 0);
	free(copy);
	free(back);
}

/* Plain C makes of the bytes what this machine's own loops did. */
static void check_alike(struct codec *codec, int64_t id, const uint8_t *bytes, size_t size, const int32_t *posts)
{
	size_t count = (size_t)codec->side * codec->side;
	int32_t *plain = malloc(count * sizeof *plain);
	const struct codec_kernels *best = codec->kernels;
	fuzz_check(plain != NULL);
	codec->kernels = &store_codec_plain;
	fuzz_check(store_codec_decode(codec, id, bytes, size, plain));
	fuzz_check(memcmp(plain, posts, count * sizeof *plain) == 0);
	codec->kernels = best;
	free(plain);
}

static int32_t word_at(const uint8_t *data, size_t size, size_t i)
{
	uint32_t value = 0;
	for (size_t b = 0; b < 4; b++)
		value |= (uint32_t)data[(4 * i + b) % size] << (8 * b);
	return (int32_t)value;
}

/* The bytes as posts: as they are, as small numbers, as a slope with holes, as few values. */
static void make_posts(const uint8_t *data, size_t size, int way, uint32_t side, int32_t *posts)
{
	for (size_t i = 0; i < (size_t)side * side; i++) {
		uint8_t byte = data[i % size];
		switch (way) {
		case 0:
			posts[i] = word_at(data, size, i);
			break;
		case 1:
			posts[i] = byte;
			break;
		case 2:
			posts[i] = byte < 32 ? CODEC_NODATA : (int32_t)(i % side * 100 + i / side * 7 + byte % 8);
			break;
		default:
			posts[i] = byte < 200 ? 0 : byte < 216 ? CODEC_NODATA : byte < 232 ? INT32_MAX : byte < 248 ? INT32_MIN + 1 : -1;
		}
	}
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct codec codec;
	if (size < HEAD)
		return 0;
	uint32_t side = side_of(data[0]);
	int64_t id = codec_of(data[1]);
	size_t bytes = (size_t)side * side * sizeof(int32_t);
	int32_t *posts = malloc(bytes), *first = malloc(bytes);
	fuzz_check(posts != NULL && first != NULL);
	fuzz_memory_allow(bytes / sizeof *posts * BYTES_A_POST + BYTES_MORE);
	fuzz_check(store_codec_init(&codec, side, (enum codec_effort)(size % CODEC_EFFORTS)) == STATUS_OK);
	bool good = store_codec_decode(&codec, id, data + HEAD, size - HEAD, first);
	if (good) {
		check_alike(&codec, id, data + HEAD, size - HEAD, first);
		check_round(&codec, first);
	}
	/* Posts of all ways from the smallest planes, of one from larger ones. */
	for (int way = 0; way < 4 && size > HEAD && side < 1025; way++)
		if (side <= 17 || way == data[1] % 4) {
			make_posts(data + HEAD, size - HEAD, way, side, posts);
			check_round(&codec, posts);
		}
	/* Again, with scratch that others have used: nothing of it shows. */
	fuzz_check(store_codec_decode(&codec, id, data + HEAD, size - HEAD, posts) == good);
	fuzz_check(!good || memcmp(posts, first, bytes) == 0);
	store_codec_finish(&codec);
	fuzz_memory_allow_all();
	free(posts);
	free(first);
	return 0;
}

/* Planes of each kind, encoded by the codec there is. */
size_t fuzz_seed(size_t index, uint8_t *data, size_t room)
{
	uint8_t side_byte = (uint8_t)(index / KINDS);
	if (side_byte >= 4)
		return 0;
	struct codec codec;
	const void *bytes;
	size_t size;
	uint32_t side = side_of(side_byte);
	int32_t *posts = malloc((size_t)side * side * sizeof *posts);
	uint64_t random = index;
	fuzz_check(posts != NULL && store_codec_init(&codec, side, (enum codec_effort)(index % CODEC_EFFORTS)) == STATUS_OK);
	for (size_t i = 0; i < (size_t)side * side; i++) {
		uint64_t any = fuzz_random(&random);
		const int32_t values[KINDS] = {
			7, (int32_t)(any % 256), (int32_t)any, (int32_t)(i * 3 + any % 4),
			any % 9 == 0 ? CODEC_NODATA : (int32_t)(i % side * 50), i % 40 < 3 ? -(int32_t)i : 0,
			i == 0 ? CODEC_NODATA : 5, i + 1 == (size_t)side * side ? CODEC_NODATA : (int32_t)i,
		};
		posts[i] = values[index % KINDS];
	}
	data[0] = side_byte;
	data[1] = (uint8_t)store_codec_encode(&codec, posts, &bytes, &size);
	if (size > room - HEAD)
		size = room - HEAD;
	memcpy(data + HEAD, bytes, size);
	store_codec_finish(&codec);
	free(posts);
	return size + HEAD;
}
