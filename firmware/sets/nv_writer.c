#include "sets/nv_writer.h"

#include <stddef.h>
#include <string.h>

#define BLANK 0xFFU

void tumble_nv_writer_init(tumble_nv_writer_t *writer, const tumble_nv_t *nv)
{
    *writer = (tumble_nv_writer_t){.nv = nv};
}

tumble_status_t tumble_nv_writer_open(tumble_nv_writer_t *writer, const tumble_nv_t *nv)
{
    const tumble_status_t status = tumble_regions_check(nv);
    if (status == TUMBLE_OK) {
        tumble_nv_writer_init(writer, nv);
    }
    return status;
}

static void begin(tumble_nv_writer_t *writer, bool changes, uint32_t offset, uint32_t size)
{
    writer->offset = offset;
    writer->size = size;
    writer->checked = 0;
    writer->changes = changes;
    writer->failed_to_hold = false;
}

void tumble_nv_begin_erase(tumble_nv_writer_t *writer, uint32_t offset, uint32_t size)
{
    writer->bytes = NULL;
    begin(writer, true, offset, size);
}

void tumble_nv_begin_program(tumble_nv_writer_t *writer, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    writer->bytes = bytes;
    begin(writer, true, offset, size);
}

void tumble_nv_begin_blank(tumble_nv_writer_t *writer, uint32_t offset, uint32_t size)
{
    writer->bytes = NULL;
    begin(writer, false, offset, size);
}

bool tumble_nv_is_blank(const uint8_t *bytes, uint32_t size)
{
    bool blank = true;
    for (uint32_t i = 0; i < size; i++) {
        blank = blank && (bytes[i] == BLANK);
    }
    return blank;
}

static tumble_status_t known(tumble_status_t status)
{
    return ((status == TUMBLE_OK) || (status == TUMBLE_E_PORT_BUSY)) ? status : TUMBLE_E_NV;
}

tumble_status_t tumble_nv_read(const tumble_nv_t *nv, uint32_t offset, uint8_t *bytes, uint32_t size)
{
    return known(nv->read(nv->context, offset, bytes, size));
}

static tumble_status_t change(tumble_nv_writer_t *writer)
{
    const tumble_nv_t *nv = writer->nv;
    const tumble_status_t status =
        known((writer->bytes == NULL) ? nv->erase(nv->context, writer->offset)
                                      : nv->program(nv->context, writer->offset, writer->bytes, writer->size));
    if (status != TUMBLE_OK) {
        return status;
    }
    writer->changes = false;
    return TUMBLE_E_PORT_BUSY;
}

static bool chunk_is_right(const tumble_nv_writer_t *writer, uint32_t size)
{
    return (writer->bytes == NULL) ? tumble_nv_is_blank(writer->chunk, size)
                                   : (memcmp(writer->chunk, &writer->bytes[writer->checked], size) == 0);
}

static tumble_status_t check(tumble_nv_writer_t *writer)
{
    const uint32_t left = writer->size - writer->checked;
    const uint32_t size = (left < TUMBLE_NV_CHUNK) ? left : TUMBLE_NV_CHUNK;
    const tumble_status_t status = tumble_nv_read(writer->nv, writer->offset + writer->checked, writer->chunk, size);
    if (status != TUMBLE_OK) {
        return status;
    }
    if (!chunk_is_right(writer, size)) {
        writer->failed_to_hold = true;
        return TUMBLE_E_NV;
    }
    writer->checked += size;
    return (writer->checked == writer->size) ? TUMBLE_OK : TUMBLE_E_PORT_BUSY;
}

tumble_status_t tumble_nv_writer_step(tumble_nv_writer_t *writer)
{
    return writer->changes ? change(writer) : check(writer);
}
