/* Defect: assembly that takes another stack, from wherever it is told to. */
    .text
    .global canary_moved
    .type   canary_moved, %function
canary_moved:
    mov     x1, sp
    mov     sp, x0
    mov     sp, x1
    ret
    .size   canary_moved, . - canary_moved
