function [mtf, edge] = edge_mtf(sensor, rect)
% MTF of the picture in display RGB, and the part of the picture that it is measured on. Each call with more than three
% colours draws sample positions anew.
ip = ipCompute(ipCreate, sensor);
edge = reshape(vcGetROIData(ip, rect, 'result'), rect(4) + 1, rect(3) + 1, 3);
mtf = mtf_of(edge, sensorGet(sensor, 'pixel width', 'mm'));
end
