/* A glTF file: its text, its lists, and the bytes of its buffers. See scene_gltf.h. */
#include "scene/scene_gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "scene/scene_file.h"

#define VALUES_MOST 2000000 /* of the text: each takes about 64 bytes of memory */
#define WHOLE_MOST 4294967296.0

enum status scene_gltf_bad(const struct scene_gltf *gltf, const char *format, ...)
{
	char why[200];
	va_list args;
	va_start(args, format);
	vsnprintf(why, sizeof why, format, args);
	va_end(args);
	return fail_with(STATUS_INPUT, "%s: it cannot be read as a mesh (%s); give a whole OBJ, STL, DAE or glTF 2 file", gltf->told, why);
}

enum status scene_gltf_whole(const struct scene_gltf *gltf, const cJSON *object, const char *key, size_t absent, size_t end, size_t *out)
{
	const cJSON *value = cJSON_GetObjectItemCaseSensitive(object, key);
	*out = absent;
	if (value == NULL)
		return STATUS_OK;
	const double number = cJSON_IsNumber(value) ? value->valuedouble : -1;
	if (!(number >= 0 && number < WHOLE_MOST && number == floor(number) && number < (double)end))
		return scene_gltf_bad(gltf, "its %s is no whole number from 0 to below %zu", key, end);
	*out = (size_t)number;
	return STATUS_OK;
}

/* --- buffers --- */

static int digit_of(char c)
{
	static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
	const char *at = c != '\0' ? strchr(digits, c) : NULL;
	return at != NULL ? (int)(at - digits) : -1;
}

static enum status take_base64(const struct scene_gltf *gltf, const char *text, struct scene_gltf_bytes *out)
{
	const size_t length = strlen(text);
	uint32_t bits = 0;
	int held = 0;
	TRY(mem_make(&out->owned, length / 4 * 3 + 4, 1, "a mesh"));
	for (size_t i = 0; i < length && text[i] != '='; i++) {
		const int digit = digit_of(text[i]);
		if (digit < 0)
			return scene_gltf_bad(gltf, "the base64 text of a buffer has a wrong sign");
		bits = bits << 6 | (uint32_t)digit;
		held += 6;
		if (held >= 8)
			out->owned[out->length++] = (char)(bits >> (held -= 8) & 0xff);
	}
	return STATUS_OK;
}

/* Writes a name as it is behind its %20s. Returns false if it is no name of a file in the same folder. */
static bool is_beside(const char *uri, char *name, size_t room)
{
	size_t length = 0;
	for (const char *at = uri; *at != '\0' && length + 1 < room; at++) {
		unsigned code;
		char hex[3] = {at[0] == '%' ? at[1] : '\0', '\0', '\0'};
		hex[1] = hex[0] != '\0' ? at[2] : '\0';
		if (hex[1] != '\0' && strspn(hex, "0123456789abcdefABCDEF") == 2 && sscanf(hex, "%x", &code) == 1) {
			name[length++] = (char)code;
			at += 2;
		} else {
			name[length++] = *at;
		}
	}
	name[length] = '\0';
	return name[0] != '\0' && name[0] != '.' && strlen(name) == length && strpbrk(name, "/\\:") == NULL;
}

static enum status take_file(struct scene_gltf *gltf, const char *uri, struct scene_gltf_bytes *out)
{
	char name[256];
	if (!is_beside(uri, name, sizeof name))
		return scene_gltf_bad(gltf, "a buffer is not in its folder: %.100s", uri);
	char *path = scene_file_beside(gltf->path, name);
	TRY_MEM(path, "a mesh");
	const enum status status = scene_file_read(path, gltf->told, gltf->left, &out->owned, &out->length);
	mem_free(path);
	TRY(status);
	gltf->left -= out->length;
	return STATUS_OK;
}

static enum status take_buffer(struct scene_gltf *gltf, size_t number, struct scene_gltf_bytes *out)
{
	const cJSON *buffer = gltf->lists[SCENE_GLTF_BUFFERS][number], *uri = cJSON_GetObjectItemCaseSensitive(buffer, "uri");
	size_t length;
	TRY(scene_gltf_whole(gltf, buffer, "byteLength", 0, SCENE_MESH_BYTES + 1, &length));
	if (uri == NULL && number == 0 && gltf->chunk.at != NULL) {
		*out = gltf->chunk;
	} else if (!cJSON_IsString(uri)) {
		return scene_gltf_bad(gltf, "a buffer has no bytes");
	} else if (strncasecmp(uri->valuestring, "data:", 5) == 0) {
		const char *text = strstr(uri->valuestring, ";base64,");
		TRY(text != NULL ? take_base64(gltf, text + strlen(";base64,"), out) : scene_gltf_bad(gltf, "a buffer is not in base64"));
	} else {
		TRY(take_file(gltf, uri->valuestring, out));
	}
	out->at = out->owned != NULL ? (const uint8_t *)out->owned : out->at;
	if (out->length < length)
		return scene_gltf_bad(gltf, "a buffer has %zu bytes and says %zu", out->length, length);
	return STATUS_OK;
}

enum status scene_gltf_view(struct scene_gltf *gltf, size_t view, size_t offset, size_t count, size_t element, const uint8_t **at, size_t *stride)
{
	const cJSON *object = gltf->lists[SCENE_GLTF_VIEWS][view];
	size_t number, begin, length;
	TRY(scene_gltf_whole(gltf, object, "buffer", gltf->counts[SCENE_GLTF_BUFFERS], gltf->counts[SCENE_GLTF_BUFFERS], &number));
	TRY(scene_gltf_whole(gltf, object, "byteOffset", 0, SCENE_MESH_BYTES + 1, &begin));
	TRY(scene_gltf_whole(gltf, object, "byteLength", 0, SCENE_MESH_BYTES + 1, &length));
	TRY(scene_gltf_whole(gltf, object, "byteStride", element, 256, stride));
	if (number == gltf->counts[SCENE_GLTF_BUFFERS])
		return scene_gltf_bad(gltf, "a buffer view names no buffer");
	struct scene_gltf_bytes *bytes = &gltf->buffers[number];
	if (bytes->at == NULL)
		TRY(take_buffer(gltf, number, bytes));
	if (begin > bytes->length || length > bytes->length - begin)
		return scene_gltf_bad(gltf, "a buffer view is longer than its buffer");
	if (count > 0 && (offset > length || element > length - offset || *stride < element || count - 1 > (length - offset - element) / *stride))
		return scene_gltf_bad(gltf, "an accessor is longer than its buffer view");
	*at = bytes->at + begin + offset;
	return STATUS_OK;
}

/* --- the text --- */

static uint32_t word_at(const char *bytes, size_t at)
{
	const uint8_t *b = (const uint8_t *)bytes + at;
	return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Finds the text and the bytes behind it in a .glb. */
static enum status unpack(struct scene_gltf *gltf, const char **bytes, size_t *length)
{
	if (*length < 20 || memcmp(*bytes, "glTF", 4) != 0 || word_at(*bytes, 4) != 2)
		return scene_gltf_bad(gltf, "it does not begin as a .glb of version 2");
	const size_t whole = *length, text = word_at(*bytes, 12);
	if (memcmp(*bytes + 16, "JSON", 4) != 0 || text > whole - 20)
		return scene_gltf_bad(gltf, "its text has %zu bytes, and the file %zu", text, whole);
	const size_t next = 20 + text;
	if (whole - next >= 8 && memcmp(*bytes + next + 4, "BIN", 4) == 0) {
		gltf->chunk = (struct scene_gltf_bytes){.at = (const uint8_t *)*bytes + next + 8, .length = word_at(*bytes, next)};
		if (gltf->chunk.length > whole - next - 8)
			return scene_gltf_bad(gltf, "its buffer has %zu bytes, and the file %zu", gltf->chunk.length, whole);
	}
	*bytes += 20;
	*length = text;
	return STATUS_OK;
}

static enum status parse(struct scene_gltf *gltf, const char *text, size_t length)
{
	size_t values = 1;
	for (size_t i = 0; i < length; i++)
		values += text[i] == ',' || text[i] == '[' || text[i] == '{';
	if (values > VALUES_MOST)
		return scene_gltf_bad(gltf, "it has more than %d values", VALUES_MOST);
	gltf->root = cJSON_ParseWithLength(text, length); /* refuses more than 1,000 brackets in each other */
	if (!cJSON_IsObject(gltf->root))
		return scene_gltf_bad(gltf, "its text is no JSON");
	const cJSON *version = cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(gltf->root, "asset"), "version");
	if (!cJSON_IsString(version) || strncmp(version->valuestring, "2.", 2) != 0)
		return scene_gltf_bad(gltf, "it is not of version 2");
	const cJSON *needed;
	cJSON_ArrayForEach(needed, cJSON_GetObjectItemCaseSensitive(gltf->root, "extensionsRequired"))
		if (cJSON_IsString(needed) && strstr(needed->valuestring, "compression") != NULL)
			return scene_gltf_bad(gltf, "it is compressed with %.60s", needed->valuestring);
	return STATUS_OK;
}

static enum status find_list(struct scene_gltf *gltf, enum scene_gltf_list list)
{
	static const char *const names[] = {"accessors", "bufferViews", "buffers", "meshes", "nodes", "scenes"};
	const cJSON *array = cJSON_GetObjectItemCaseSensitive(gltf->root, names[list]), *item;
	const size_t room = cJSON_IsArray(array) ? (size_t)cJSON_GetArraySize(array) : 0;
	TRY(mem_zeroed(&gltf->lists[list], room + 1, sizeof *gltf->lists[list], "a mesh"));
	if (room > 0)
		cJSON_ArrayForEach(item, array)
			gltf->lists[list][gltf->counts[list]++] = item;
	return STATUS_OK;
}

enum status scene_gltf_open(struct scene_gltf *gltf, const char *path, const char *told, bool packed, const char *bytes, size_t length)
{
	*gltf = (struct scene_gltf){.path = path, .told = told, .left = SCENE_MESH_BYTES - length};
	if (packed)
		TRY(unpack(gltf, &bytes, &length));
	TRY(parse(gltf, bytes, length));
	for (int list = 0; list < SCENE_GLTF_LISTS; list++)
		TRY(find_list(gltf, (enum scene_gltf_list)list));
	return mem_zeroed(&gltf->buffers, gltf->counts[SCENE_GLTF_BUFFERS] + 1, sizeof *gltf->buffers, "a mesh");
}

void scene_gltf_close(struct scene_gltf *gltf)
{
	for (size_t i = 0; gltf->buffers != NULL && i < gltf->counts[SCENE_GLTF_BUFFERS]; i++)
		mem_free(gltf->buffers[i].owned);
	mem_free(gltf->buffers);
	for (int list = 0; list < SCENE_GLTF_LISTS; list++)
		mem_free(gltf->lists[list]);
	cJSON_Delete(gltf->root);
}
